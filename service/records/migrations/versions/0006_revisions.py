"""Revisions of jobs, and an index that finds the jobs that share a store.

Revision ID: 0006
Revises: 0005
"""

import sqlalchemy as sa
from alembic import op

revision = "0006"
down_revision = "0005"
branch_labels = None
depends_on = None


def upgrade() -> None:
    with op.batch_alter_table("jobs") as jobs:
        jobs.add_column(sa.Column("revision", sa.Integer, nullable=False, server_default="0"))
        jobs.create_index("ix_jobs_store", ["store"])


def downgrade() -> None:
    with op.batch_alter_table("jobs") as jobs:
        jobs.drop_index("ix_jobs_store")
        jobs.drop_column("revision")
