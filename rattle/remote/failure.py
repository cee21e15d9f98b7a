"""What a service says is wrong, as an exception."""

import httpx2 as httpx


class ServiceFailed(Exception):
    """A service does not answer, or refuses.

    Attributes
    ----------
    status : int or None
        HTTP status; None if there was no answer.

    Examples
    --------
    >>> import rattle
    >>> try:
    ...     rattle.connect("http://127.0.0.1:8000").job("0" * 32)
    ... except rattle.ServiceFailed as error:
    ...     print(error.status)
    404
    """

    def __init__(self, message: str, status: int | None = None) -> None:
        super().__init__(message)
        self.status = status

    @property
    def request_is_wrong(self) -> bool:
        """Whether another request would be answered."""
        return self.status in (400, 401, 403, 404, 422)


def detail_of(response: httpx.Response) -> str:
    """What the service says is wrong."""
    try:
        detail = str(response.json()["detail"])
    except (ValueError, KeyError, TypeError):
        detail = f"{response.url} answered {response.status_code}"
    return detail + ("; give a key" if response.status_code == 401 else "")
