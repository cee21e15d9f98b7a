"""Alembic's entry point: migrations run on the connection that `service.database` opened."""

from alembic import context

from service.event_record import EventRecord
from service.job_record import JobRecord
from service.key_record import KeyRecord

# A table that has been imported is known to the metadata that they share.
TABLES = JobRecord, KeyRecord, EventRecord

context.configure(connection=context.config.attributes["connection"], target_metadata=TABLES[0].metadata)
with context.begin_transaction():
    context.run_migrations()
