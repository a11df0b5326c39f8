"""One thread for linear algebra on small matrices, where more would only wait for each other."""

from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache

from threadpoolctl import ThreadpoolController


@cache
def _pools() -> ThreadpoolController:
    """Return the thread pools of this process: finding them costs more than limiting them."""
    return ThreadpoolController()


@contextmanager
def one_thread() -> Iterator[None]:
    """Run linear algebra in the calling thread alone."""
    with _pools().limit(limits=1):
        yield
