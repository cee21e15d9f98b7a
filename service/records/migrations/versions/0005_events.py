"""Events of each job.

Revision ID: 0005
Revises: 0004
"""

import sqlalchemy as sa
from alembic import op

revision = "0005"
down_revision = "0004"
branch_labels = None
depends_on = None


def upgrade() -> None:
    events = op.create_table(
        "events",
        sa.Column("job_id", sa.String(32), primary_key=True),
        sa.Column("sequence", sa.Integer, primary_key=True, autoincrement=False),
        sa.Column("state", sa.String(16), nullable=False),
        sa.Column("progress", sa.JSON),
        sa.Column("error", sa.JSON),
        sa.Column("moment", sa.DateTime(timezone=True), nullable=False),
    )
    jobs = sa.table("jobs", sa.column("id"), sa.column("state"), sa.column("created"))
    # Existing jobs begin with their current state.
    now = sa.select(jobs.c.id, sa.literal(1), jobs.c.state, jobs.c.created)
    op.get_bind().execute(events.insert().from_select(["job_id", "sequence", "state", "moment"], now))


def downgrade() -> None:
    op.drop_table("events")
