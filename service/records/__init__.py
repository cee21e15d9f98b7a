"""Records in the database: jobs, keys, events. No other folder knows SQLAlchemy."""
