"""What can go wrong with work, grouped by what a caller would do about it.

WorkerError +-- InvalidJob       the request is at fault: correct it (also a ValueError) +-- StoreConflict    something
else lies at the location: choose another, or delete it +-- StoreFailed      the store could not be read or written: the
message holds the system's reason; resume when it is mended +-- TileFailed       a tile kept failing: the message names
it and its last error +-- ClusterFailed    no scheduler or no worker answered +-- JobCancelled     somebody asked for it
"""


class WorkerError(Exception):
    """Anything that work can fail with."""


class InvalidJob(WorkerError, ValueError):
    """The job cannot be computed as described."""


class StoreConflict(WorkerError):
    """The location holds something that is not this job's store."""


class StoreFailed(WorkerError):
    """The store could not be read or written."""


class TileFailed(WorkerError):
    """A tile failed more often than retries allow."""


class ClusterFailed(WorkerError):
    """The scheduler or its workers cannot be reached."""


class JobCancelled(WorkerError):
    """The job was cancelled; what had been computed is in the store, and its ledger tells what."""
