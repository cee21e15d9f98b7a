"""Records in the database: jobs, keys, events. The only folder that knows SQLAlchemy."""
