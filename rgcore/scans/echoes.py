"""What a reading means: an echo, no echo (``inf``) or no information (``nan``).

Logs write "no echo" as a code among the ranges: the top value of the scanner's number format (8183 to 8191 counts of
1 cm or 1 mm with SICK scanners, 32767 mm, ...), its nominal range, or 0. They are found in the data, from the top down.
"""

from __future__ import annotations

import numpy as np

_KNOWN = (
    (81.825, 81.925),  # SICK, 13 bits of 1 cm: 8183 ... 8191
    (79.995, 80.005),
    (50.995, 51.995),  # CARMEN's laser server
    (49.995, 50.005),
    (32.755, 32.775),  # 15 bits of 1 mm
    (16.380, 16.395),  # 14 bits of 1 mm
    (8.1825, 8.1925),  # SICK, 13 bits of 1 mm
)
"""m, codes that logs are known to use; one counts only where no echo lies above it."""

_ABSURD = 200.0  # m, no planar laser sees farther
_REPEATS = 20  # a value seen less often than this is not taken for a code that nobody announced
_PEAK = 10  # and it must be this many times as frequent as any value near below it
_SAME = 0.999  # readings within 0.1 % of the top value may be the same code: counts 8183 to 8191
_NEAR = 0.8  # "near below" reaches down to this part of it
_OTHERS = 0.2  # a code leaves at least this part of the readings as echoes


def mark_echoes(readings: np.ndarray, declared: float | None = None) -> tuple[np.ndarray, float, list[str]]:
    """Readings (N, B) [m] as a log writes them -> the same with ``inf`` = no echo and ``nan`` = no information.

    declared: the laser's maximum range [m] by the log itself, if it names one.
    Returns also the longest echo [m] and notes on what was found. A zero is "no echo" only in a log that has no other
    code for it: elsewhere it is a reading that failed. Negative and absurd numbers are no information.
    """
    ranges = np.where(readings > 0, readings, np.nan)
    limit, codes = _lowest_code(ranges[np.isfinite(ranges)], declared)
    notes = []
    with np.errstate(invalid="ignore"):
        silent = ranges >= limit
        if codes:
            notes.append(f"no echo is written as {', '.join(f'{c:g}' for c in codes)} m ({int(silent.sum())} readings)")
        elif not np.isinf(ranges).any() and (zero := readings == 0).any():
            silent = zero
            notes.append(f"no echo is written as 0 ({int(zero.sum())} readings)")
        absurd = ~silent & (ranges > _ABSURD) & np.isfinite(ranges)
    if absurd.any():
        notes.append(f"{int(absurd.sum())} readings above {_ABSURD:g} m ignored")
    ranges[absurd] = np.nan
    ranges[silent] = np.inf
    echoes = ranges[np.isfinite(ranges)]
    return ranges, float(echoes.max()) if len(echoes) else 0.0, notes


def _lowest_code(values: np.ndarray, declared: float | None) -> tuple[float, list[float]]:
    """From which value on a reading is no echo, and the codes found (the top value of each)."""
    known = _KNOWN if declared is None or declared <= 0 else (*_KNOWN, (declared * _SAME, declared / _SAME))
    total, limit, codes = len(values), np.inf, []
    values = values[~_stray(values, known)]
    while len(values):
        top = float(values.max())
        floor = next((low for low, high in known if low <= top <= high), None)
        if floor is None and _is_peak(values, top, total):
            floor = top
        if floor is None and top <= _ABSURD:
            break
        if floor is not None:
            limit = floor
            codes.append(top)
        values = values[values < (top if floor is None else floor)]
    return limit, codes


def _stray(values: np.ndarray, known: tuple[tuple[float, float], ...]) -> np.ndarray:
    """Mask of absurd values too rare for a code: a log in millimetres has as many as readings, and the search below
    would take them off one by one."""
    absurd = values > _ABSURD
    found, count = np.unique(values[absurd], return_counts=True)
    announced = np.any([(found >= low) & (found <= high) for low, high in known], axis=0)
    absurd[absurd] = np.isin(values[absurd], found[(count < _REPEATS) & ~announced])
    return absurd


def _is_peak(values: np.ndarray, top: float, total: int) -> bool:
    """Whether the top value repeats as no echo does: far oftener than the values near below it."""
    repeats = np.count_nonzero(values == top)
    others = values[values < top * _SAME]
    if repeats < _REPEATS or len(others) < _OTHERS * total:
        return False
    near = others[others > top * _NEAR]
    usual = int(np.unique(near, return_counts=True)[1].max()) if len(near) else 0
    return bool(repeats >= _PEAK * usual)
