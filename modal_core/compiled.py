"""Loops over samples, compiled when they are first called."""

from collections.abc import Callable
from typing import cast, TypeVar

import numba

Function = TypeVar('Function', bound=Callable[..., object])


def compiled(function: Function) -> Function:
    """Return a function of numbers and arrays as machine code, kept for the next run.

    What is kept is forgotten when the function's own file changes, and only then: compiled
    functions that call each other belong in one file.  Where no folder can be written to, a
    function is compiled anew in every run.
    """
    try:
        return cast(Function, numba.njit(cache=True, nogil=True)(function))
    except RuntimeError:
        return cast(Function, numba.njit(nogil=True)(function))
