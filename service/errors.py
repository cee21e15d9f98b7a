"""Errors that the service raises itself. `service.problems` turns them into responses."""


class JobNotFound(Exception):
    """No job has this id."""


class NotReady(Exception):
    """The requested result does not exist yet."""


class WrongKind(Exception):
    """The job is of a kind that has nothing of what is requested."""


class LimitExceeded(Exception):
    """The request is larger than this service allows."""


class TooMuch(Exception):
    """A quota is exhausted for now.

    Attributes
    ----------
    seconds : int
        Time after which the client may try again.
    """

    def __init__(self, message: str, seconds: int) -> None:
        super().__init__(message)
        self.seconds = seconds


class Unstoppable(Exception):
    """A job did not stop in time."""


class NotYours(Exception):
    """The job belongs to another caller."""
