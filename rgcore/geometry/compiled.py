"""How inner loops are compiled: ``kernel`` for what Python calls (kept on disk), ``inner`` for what only kernels call.

An inner function has no entry from Python and goes into its kernels whole; leaving the entry out saves a third of the
time of compiling. Plain loops over rows compile several times faster than array expressions. The cache on disk notices
changes of a kernel's own file only: after changing an inner function of another file, touch the kernel's.
"""

from __future__ import annotations

from numba import njit

kernel = njit(cache=True, nogil=True, error_model="numpy")
inner = njit(nogil=True, error_model="numpy", no_cpython_wrapper=True, no_cfunc_wrapper=True)  # type: ignore[call-overload]
