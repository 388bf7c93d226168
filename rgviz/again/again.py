"""The new run of the open project, from the start of its mapping until it is accepted or discarded: one for everybody.

The mapping runs in a child process, the plan of what becomes of the edits is made on a thread; the map stays on show
and can be edited all the while. An edit that is made meanwhile makes the plan old, and it is made anew.
"""

from __future__ import annotations

import logging
import threading
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from rgcore.config import Config
from rgcore.errors import EditError, RgError, one_line
from rgcore.model.outcome import LEAVE, Choice, Key, Outcome
from rgcore.model.project import Project
from rgcore.model.rerun import Plan, plan_rerun
from rgcore.model.staged import Staged, discard, points_of_staged, read_staged
from rgviz import status
from rgviz.again.comparing import Comparison
from rgviz.again.kinds import by_need
from rgviz.again.logs import Log, logs_for
from rgviz.again.settings import config_of, with_values
from rgviz.jobs import Finished, Report, RerunJob

if TYPE_CHECKING:
    from rgviz.app import App

log = logging.getLogger(__name__)


class Proposal(NamedTuple):
    """The new run with the edits on it: ``points`` (K, 2) [m] are its echoes."""

    plan: Plan
    comparison: Comparison
    points: np.ndarray

    @classmethod
    def of(cls, project: Project, staged: Staged) -> Proposal:
        """Raises RgError."""
        plan = plan_rerun(project, staged)
        before, after = project.trajectory, staged.trajectory
        comparison = Comparison.of("the new run", plan.history.map, plan.map, before, after)
        return cls(plan, comparison, points_of_staged(project.path))


class Again:
    """All methods but ``stop`` run on the editor's thread.

    given    logs that were named where the server was started
    job      the mapping that runs; ``what``: of which log
    staged   the new run that waits; ``proposal``: what would become of the edits, None until that is known
    chosen   what people decided about outcomes, by the edit's key
    trouble  why the last mapping came to nothing
    """

    def __init__(self, app: App) -> None:
        self.app = app
        self.given: tuple[Path, ...] = ()
        self.job: RerunJob | None = None
        self.what = ""
        self.pace = status.Pace()
        self.project: Project | None = None
        self.staged: Staged | None = None
        self.proposal: Proposal | None = None
        self.chosen: dict[Key, Choice] = {}
        self.trouble = ""
        self._planning = self._outdated = False

    # ---- told by the app --------------------------------------------------------------------------

    def opened(self, project: Project) -> None:
        """A project is on show; perhaps a new run waits in it since the last time."""
        if project is self.project:
            return
        self.project = project
        if not project.read_only:
            self._look()

    def map_changed(self) -> None:
        """Somebody edited: what would become of that edit is not in the plan yet."""
        if self.staged is not None:
            self._plan_anew()

    def stop(self) -> None:
        if self.job is not None:
            self.job.cancel()

    # ---- asked for by people ----------------------------------------------------------------------

    @property
    def logs(self) -> list[Log]:
        """What can be mapped, the project's own log first."""
        source = self.app.playback.source
        own = (source.log, source.topics) if source is not None else None
        return logs_for(self._open.path, own, self.given)

    @property
    def config(self) -> Config:
        """The settings of the current run."""
        return config_of(self._open.run_info)

    def start(self, log: int, values: Mapping[str, str]) -> None:
        """Map the log of that number in ``logs``, with the settings of the current run but for ``values``.

        Raises EditError for what is not on offer, SettingError for what is out of bounds.
        """
        if self.job is not None:
            raise EditError("A log is being mapped; wait for it, or cancel it.")
        self._open.must_write()
        logs = self.logs
        if not 0 <= log < len(logs):
            raise EditError("That log is not on offer any more.")
        config = with_values(self.config, values)
        self.what, self.trouble, self.pace = logs[log].title, "", status.Pace()
        self.job = RerunJob(
            logs[log].path, self._open.path, config, lambda m: self.app.worker.post(self._hear, m), logs[log].topics
        )
        self._tell()

    def cancel(self) -> None:
        """Stop the mapping; all stays as it is."""
        if self.job is not None:
            self.job.cancel()
            self.job = None
            self._tell()

    def choose(self, outcome: Outcome, choice: Choice | None) -> None:
        """What is to become of an outcome of the plan; None: as the plan says."""
        if choice is None:
            self.chosen.pop(outcome.key, None)
        else:
            self.chosen[outcome.key] = choice
        self._tell()

    def accept(self) -> None:
        """Make the new run the current one. Raises RgError, also where the plan is not ready; nothing changes then."""
        project = self._open
        if self.proposal is None or self.proposal.plan.history is not project.history:
            raise EditError("The edits are still being looked at; wait a moment and accept again.")
        project.accept(self.proposal.plan, self.choices)
        self._forget()
        self.app.show_session(self.app.opened)
        self.app.playback.opened(project)
        self._tell()

    def discard(self) -> None:
        """The new run goes; all is as it was."""
        self._open.must_write()
        discard(self._open.path)
        self._forget()
        self._tell()

    @property
    def outcomes(self) -> Sequence[Outcome]:
        return self.proposal.plan.outcomes if self.proposal is not None else ()

    @property
    def in_need(self) -> list[Outcome]:
        """The outcomes of the plan, else the edits that wait since an earlier run: those first that need a person."""
        waiting = self.app.session.project.conflicts if self.app.session is not None else ()
        return by_need(self.outcomes if self.proposal is not None else waiting)

    @property
    def choices(self) -> dict[int, Choice]:
        """What people chose, by the number of the outcome; what is not on offer any more does not count."""
        out: dict[int, Choice] = {}
        for n, o in enumerate(self.outcomes):
            choice = self.chosen.get(o.key)
            if choice is not None and (choice in o.remedies if o.waits else choice == LEAVE):
                out[n] = choice
        return out

    @property
    def ready(self) -> bool:
        """Whether it is known what becomes of every edit, the last one included."""
        return self.proposal is not None and not self._planning

    # ---- parts ------------------------------------------------------------------------------------

    @property
    def _open(self) -> Project:
        return self.app.opened.project

    def _hear(self, message: Report | Finished) -> None:
        if self.job is None:
            return  # it was cancelled
        if isinstance(message, Report):
            self.pace.hear(message)
            self._tell()
            return
        self.job = None
        self.trouble = message.error or ""
        if message.error is None:
            self._forget()
            self._look()
        self._tell()

    def _look(self) -> None:
        """See whether a new run waits, and what would become of the edits."""
        assert self.project is not None
        try:
            self.staged = read_staged(self.project.path)
        except RgError as e:
            self.trouble = one_line(e)
        if self.staged is not None:
            self._plan_anew()

    def _plan_anew(self) -> None:
        """On a thread, one plan at a time: it takes a second or more."""
        if self._planning:
            self._outdated = True
            return
        self._planning, self._outdated = True, False
        work = (self.project, self.staged)
        threading.Thread(target=self._make_plan, args=work, name="rgviz plan", daemon=True).start()

    def _make_plan(self, project: Project, staged: Staged) -> None:
        try:
            made: Proposal | str = Proposal.of(project, staged)
        except RgError as e:
            made = one_line(e)
        except Exception:
            log.exception("the new run could not be looked at")
            made = "The new run could not be looked at: a fault in rgviz. The terminal says more."
        self.app.worker.post(self._planned, staged, made)

    def _planned(self, staged: Staged, made: Proposal | str) -> None:
        self._planning = False
        if self.staged is not None and (self._outdated or staged is not self.staged):
            self._plan_anew()
        if staged is self.staged:
            self.proposal = self.proposal if isinstance(made, str) else made
            self.trouble = made if isinstance(made, str) else ""
        self._tell()

    def _forget(self) -> None:
        self.staged = self.proposal = None
        self.chosen = {}

    def _tell(self) -> None:
        """Every browser sees how it stands."""
        for view in self.app.views.values():
            view.again_changed()
