"""The player: which scan of a tape is on show, as time goes by and people press buttons. No clock, no browser."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np

from rgviz.play.tape import Tape

Speed = Literal["1x", "4x", "max"]
SPEEDS: tuple[Speed, ...] = get_args(Speed)
FACTOR: dict[str, float] = {"1x": 1.0, "4x": 4.0}

LEAD = 0.5
"""s of playing that are mapped ahead, so that the picture does not stutter"""
REPLAY = 400.0
"""scans a second at which what is mapped already is shown at ``max``"""


@dataclass
class Player:
    """What is on show of a tape: play, pause, a speed, another place.

    ``at`` is the scan on show (-1 before the first), ``goal`` a scan further on that is being mapped at full speed.
    """

    tape: Tape
    speed: Speed = "1x"
    playing: bool = False
    at: int = -1
    goal: int | None = None
    _time: float = 0.0
    _newest: bool = True
    """whether the last scan that was mapped is on show: then ``max`` shows each that comes"""

    @property
    def ended(self) -> bool:
        return self.at == self.tape.total - 1

    @property
    def busy(self) -> bool:
        """Whether there is anything to come without another word from a person."""
        return self.playing or self.goal is not None

    @property
    def wanted(self) -> int:
        """How many scans should be mapped by now."""
        mapped, total = len(self.tape), self.tape.total
        ahead = 0
        if self.goal is not None:
            ahead = self.goal + 1
        elif self.playing and self.speed == "max":
            ahead = total
        elif self.playing:
            until = self._time + LEAD * FACTOR[self.speed]
            ahead = min(int(np.searchsorted(self.tape.times, until, side="right")) + 1, total)
        return max(mapped, ahead)

    def play(self) -> None:
        """Go on; from the beginning where the end is on show."""
        if self.ended:
            self.seek(0)
        self.playing = True

    def pause(self) -> None:
        self.playing, self.goal = False, None

    def seek(self, scan: int) -> None:
        """Show another scan: at once where it is mapped, else as soon as it is."""
        scan = min(max(scan, 0), self.tape.total - 1)
        mapped = len(self.tape)
        self.goal = scan if scan >= mapped else None
        if scan < mapped:
            self._show(scan)

    def step(self, scans: int) -> None:
        """So many scans on, or back, and stop there."""
        self.seek(max(self.at, 0) + scans)
        self.playing = False

    def tick(self, seconds: float) -> bool:
        """So much time has passed; whether another scan is on show now."""
        before, mapped = self.at, len(self.tape)
        if self.goal is not None:
            self._show(min(self.goal, mapped - 1))
            self.goal = None if self.at == self.goal else self.goal
        elif self.playing and self.speed == "max":
            step = mapped if self._newest else math.ceil(REPLAY * seconds)
            self._show(min(self.at + step, mapped - 1))
        elif self.playing and mapped:
            self._advance(FACTOR[self.speed] * seconds, mapped)
        if self.playing and self.ended:
            self.playing = False
        return self.at != before

    def _advance(self, seconds: float, mapped: int) -> None:
        """By the log's own time; where the mapping is behind, the time waits for it."""
        time = min(self._time + seconds, float(self.tape.times[mapped - 1]))
        self._show(int(np.searchsorted(self.tape.times, time + 1e-9, side="right")) - 1)
        self._time = time

    def _show(self, scan: int) -> None:
        if scan >= 0:
            self.at, self._time = scan, float(self.tape.times[scan])
        self._newest = self.at >= len(self.tape) - 1
