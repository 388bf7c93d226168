"""How inner loops are compiled: ``kernel`` for what Python calls (kept on disk), ``inner`` for what only kernels call.

An inner function has no entry from Python and goes into its kernels whole; leaving the entry out saves a third of the
time of compiling. Plain loops over rows compile several times faster than array expressions.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

from numba import njit

inner = njit(nogil=True, error_model="numpy", no_cpython_wrapper=True, no_cfunc_wrapper=True)  # type: ignore[call-overload]


def kernel(function: Callable[..., Any]) -> Any:
    """The function compiled on its first call with given types, and kept on disk for later processes."""
    compiled: Any = njit(cache=True, nogil=True, error_model="numpy")(function)
    compiled._cache._cache_file._source_stamp = _STAMP
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
