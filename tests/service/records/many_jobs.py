"""Jobs by the hundred thousand, made in the database in seconds."""

import sqlalchemy as sa

from service.records.engine import connect_database
from service.records.job_record import JobRecord

_FIRST = 10**15


def id_of_copy(number):
    """32 digits."""
    return f"{_FIRST}{_FIRST + number}"


def add_copies(database, job_id, copies):
    """Add so many jobs, alike but for their ids, digests and stores, to the database at a URL."""
    jobs = JobRecord.__table__
    numbers = sa.select(sa.literal(_FIRST, sa.BigInteger).label("i")).cte("numbers", recursive=True)
    numbers = numbers.union_all(sa.select(numbers.c.i + 1).where(numbers.c.i < _FIRST + copies - 1))
    own = sa.literal(str(_FIRST)) + sa.cast(numbers.c.i, sa.String)
    alike = [column for column in jobs.c if column.name not in ("number", "id", "digest", "answering", "store")]
    names = ["id", "digest", "answering", "store", *(column.name for column in alike)]
    made = sa.select(own, own, own, own, *alike).select_from(jobs.join(numbers, jobs.c.id == job_id))
    engine = connect_database(database)
    with engine.begin() as connection:
        connection.execute(jobs.insert().from_select(names, made))
    engine.dispose()
