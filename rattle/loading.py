"""Loading libraries: a first basin takes a second to load them, and looking for garbage would add half of that."""

import contextlib
import gc
from collections.abc import Iterator


@contextlib.contextmanager
def without_collections() -> Iterator[None]:
    """Load modules without looking for garbage, and take what they define for old.

    What a module defines stays. Yet each look goes over all that is young, and everything is at first.
    """
    looks = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if not gc.get_freeze_count():  # freezing moves objects away unseen, thawing gives them back as old ones
            gc.freeze()
            gc.unfreeze()
        if looks:
            gc.enable()
