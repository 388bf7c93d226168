"""What the panel says where there is no map to edit: how far the mapping is, why it failed, who holds the project."""

from __future__ import annotations

import time
from html import escape

from rgcore.model.project import Project
from rgviz import theme
from rgviz.jobs import Report
from rgviz.markup import wrap

STAGES = {
    "read": "Reading the log",
    "extract": "Finding segments",
    "slam": "Finding the robot's way",
    "freespace": "Seeing free space",
    "places": "Finding regions and gateways",
    "adapt": "Adapting to each region",
    "lines": "Merging lines",
    "accuracy": "Measuring accuracy",
    "classes": "Telling classes",
    "objects": "Finding objects",
    "save": "Writing the project",
}
"""The steps in their order, in words for a person."""


class Pace:
    """Follows the reports of a mapping job and knows how fast it goes."""

    def __init__(self, again: bool = False) -> None:
        """``again``: the log of a project is mapped only to be watched."""
        self.again = again
        self.report: Report | None = None
        self._began = (0.0, 0)

    def hear(self, report: Report) -> None:
        if self.report is None or self.report.stage != report.stage:
            self._began = (time.monotonic(), report.done)
        self.report = report

    @property
    def rate(self) -> float | None:
        """Scans a second in the stage that counts scans; None where there is nothing to tell yet."""
        took = time.monotonic() - self._began[0]
        if self.report is None or self.report.stage != "slam" or took < 0.3 or self.report.done <= self._began[1]:
            return None
        return (self.report.done - self._began[1]) / took


def progress(pace: Pace) -> str:
    """Step, share and pace of the mapping."""
    r = pace.report
    if r is None:
        return wrap('<div class="rg-h">Mapping</div>Starting ...')
    share = 100 * r.done / r.total if r.total else 0.0
    number = list(STAGES).index(r.stage) + 1 if r.stage in STAGES else 0
    known = f"{share:.0f} %" if r.total > 1 else ""
    rate = f"{pace.rate:,.0f} scans/s" if pace.rate is not None else ""
    steps = 100 * (number - 1 + share / 100) / len(STAGES)
    bars = _bar(share, theme.css(theme.BRAND)) if r.total > 1 else ""
    return wrap(
        f'<div class="rg-h" id="rg-progress">Mapping<small>step {number} of {len(STAGES)}</small></div>'
        f'{escape(STAGES.get(r.stage, r.stage))} <span class="muted">{", ".join(t for t in (known, rate) if t)}</span>'
        f"{bars}{_bar(steps, '#9aa0a8')}"
    )


def waiting(title: str, pace: Pace) -> str:
    """What stands in the inspector while the map is being made."""
    scans = f"<p>{pace.report.scans:,} scans.</p>" if pace.report is not None and pace.report.scans else ""
    text = "The map grows as the log is read. It can be corrected as soon as it is done."
    if pace.again:
        text = "This is how the log is mapped, as the robot drives. To correct the map, go back to it."
    return wrap(f'<div class="rg-h">{escape(title)}</div>{scans}<p class="muted">{text}</p>')


def failed(why: str) -> str:
    return wrap(f'<div class="rg-h">The map could not be made</div><div class="error">{escape(why)}</div>')


def held(project: Project) -> str:
    """Why the project cannot be edited here; empty if it can."""
    if not project.read_only:
        return ""
    who = f" It is open in {escape(str(project.holder))}." if project.holder else ""
    return wrap(f'<div class="rg-h">Read-only</div><div class="error">Edits are not possible here.{who}</div>')


def _bar(share: float, color: str) -> str:
    return f'<div class="bar"><i style="width:{share:.1f}%;background:{color}"></i></div>'
