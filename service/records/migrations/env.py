"""Alembic's entry point. Migrations run on the connection that `service.records.engine` has opened."""

from alembic import context

from service.records.events import EventRecord
from service.records.job_record import JobRecord
from service.records.keys import KeyRecord

# Importing a table adds it to the metadata that all tables share.
TABLES = JobRecord, KeyRecord, EventRecord

context.configure(connection=context.config.attributes["connection"], target_metadata=TABLES[0].metadata)
with context.begin_transaction():
    context.run_migrations()
