"""How inner loops are compiled: ``kernel`` for what Python calls (kept on disk), ``inner`` for what only kernels call.

An inner function has no entry from Python and goes into its kernels whole; leaving the entry out saves a third of the
time of compiling. Plain loops over rows compile several times faster than array expressions.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from numba import njit, types


def kernel(function: Callable[..., Any]) -> Any:
    """The function compiled on its first call with given types, and kept on disk for later processes."""
    compiled = _compiled(function, cache=True)
    compiled._cache._cache_file._source_stamp = _STAMP
    return compiled


def inner(function: Callable[..., Any]) -> Any:
    """The function as a part of the kernels that call it."""
    return _compiled(function, no_cpython_wrapper=True, no_cfunc_wrapper=True)


def _compiled(function: Callable[..., Any], **options: bool) -> Any:
    """Where one kernel calls another, a literal is taken for any number of its type.

    A counter that starts at 0 is the literal 0 while numba finds out the types of a loop, and what it is given to
    would be compiled for that literal first and then again for integers: a quarter of all the time of compiling.
    """
    compiled: Any = njit(nogil=True, error_model="numpy", **options)(function)  # type: ignore[call-overload]
    by_types = compiled.get_call_template

    def by_wide_types(args: Sequence[types.Type], named: dict[str, types.Type]) -> Any:
        return by_types([types.unliteral(a) for a in args], {name: types.unliteral(a) for name, a in named.items()})

    compiled.get_call_template = by_wide_types
    return compiled


def _stamp() -> tuple[tuple[str, int, int], ...]:
    """Name, time and size of every source file that has kernels or inner functions.

    numba keeps a kernel until the kernel's *own* file changes, and so would run old code after a change of an inner
    function in another file. With this stamp all are compiled anew after a change of any.
    """
    sources = Path(__file__).parents[1].rglob("*.py")
    with_kernels = [f for f in sources if f == Path(__file__) or b"geometry.compiled import" in f.read_bytes()]
    return tuple(sorted((f.name, f.stat().st_mtime_ns, f.stat().st_size) for f in with_kernels))


_STAMP = _stamp()
