"""Leases of running jobs, sizes that quotas count, and the store that a job continues.

Revision ID: 0003
Revises: 0002
"""

import sqlalchemy as sa
from alembic import op

revision = "0003"
down_revision = "0002"
branch_labels = None
depends_on = None

_INDEXES = {
    "ix_jobs_waiting": ["state", "submitter", "number"],
    "ix_jobs_served": ["submitter", "started"],
    "ix_jobs_finished": ["finished"],
    "ix_jobs_digest": ["digest"],
}


def upgrade() -> None:
    with op.batch_alter_table("jobs") as table:
        table.add_column(sa.Column("lease_owner", sa.String(64)))
        table.add_column(sa.Column("lease_until", sa.Float))
        table.add_column(sa.Column("places", sa.BigInteger, nullable=False, server_default="0"))
        table.add_column(sa.Column("store", sa.String(32)))
    jobs = sa.table("jobs", sa.column("id", sa.String), sa.column("store", sa.String))
    op.get_bind().execute(jobs.update().values(store=jobs.c.id))
    for name, columns in _INDEXES.items():
        op.create_index(name, "jobs", columns)


def downgrade() -> None:
    for name in _INDEXES:
        op.drop_index(name, "jobs")
    with op.batch_alter_table("jobs") as table:
        for column in ("lease_owner", "lease_until", "places", "store"):
            table.drop_column(column)
