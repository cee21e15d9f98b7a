"""Kind and submitter of each job.

Revision ID: 0002
Revises: 0001
"""

import sqlalchemy as sa
from alembic import op

revision = "0002"
down_revision = "0001"
branch_labels = None
depends_on = None


def upgrade() -> None:
    with op.batch_alter_table("jobs") as table:
        table.add_column(sa.Column("kind", sa.String(16), nullable=False, server_default="basin"))
        table.add_column(sa.Column("submitter", sa.String(64), nullable=False, server_default="local"))
    jobs = sa.table("jobs", sa.column("number", sa.Integer), sa.column("kind", sa.String), sa.column("request", sa.JSON))
    connection = op.get_bind()
    for number, request in connection.execute(sa.select(jobs.c.number, jobs.c.request)).all():
        if "vary" in request:
            connection.execute(jobs.update().where(jobs.c.number == number).values(kind="sweep"))
    op.create_index("ix_jobs_submitter", "jobs", ["submitter"])


def downgrade() -> None:
    op.drop_index("ix_jobs_submitter", "jobs")
    with op.batch_alter_table("jobs") as table:
        table.drop_column("submitter")
        table.drop_column("kind")
