"""Alembic's entry point: migrations run on the connection that `service.database` opened."""

from alembic import context

from service.job_record import Base

context.configure(connection=context.config.attributes["connection"], target_metadata=Base.metadata)
with context.begin_transaction():
    context.run_migrations()
