"""Loops over samples, compiled when they are first called."""

from collections.abc import Callable
from typing import Any, cast, TypeVar

import numba

Function = TypeVar('Function', bound=Callable[..., object])


def compiled(function: Function) -> Function:
    """Return a function of numbers and arrays as machine code, kept for the next run.

    What is kept is forgotten when the function's own file changes, and only then: compiled
    functions that call each other belong in one file.  Where no folder can be written to, a
    function is compiled anew in every run.
    """
    return _kept(function)


def compiled_for(signature: Any) -> Callable[[Function], Function]:
    """Return a decorator as :func:`compiled`, for one signature and at once.

    Where the signature has functions (``numba.types.FunctionType``), compiled ones are called by
    their address: what calls them is compiled once for all of them, and they may be in any file.
    """
    return lambda function: _kept(function, signature)


def _kept(function: Function, *signature: Any) -> Function:
    try:
        return cast(Function, numba.njit(*signature, cache=True, nogil=True)(function))
    except RuntimeError:
        return cast(Function, numba.njit(*signature, nogil=True)(function))
