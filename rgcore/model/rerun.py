"""A new run of a project: the plan of what becomes of every edit, to be looked at before it is accepted."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import msgspec
import numpy as np

from rgcore.errors import EditError, ProjectError
from rgcore.model import folder
from rgcore.model.drift import Drift
from rgcore.model.history import AnyEntry, Done, History, Settle, now, replay, step
from rgcore.model.journal import Journal
from rgcore.model.outcome import LEAVE, Choice, Key, Outcome, Remedy
from rgcore.model.rebase import Rebased, Source, rebase
from rgcore.model.records import RGMap
from rgcore.model.staged import Staged
from rgcore.slam.trajectory import Trajectory

if TYPE_CHECKING:
    from rgcore.model.project import Project
    from rgcore.pipeline import Run


@dataclass(frozen=True)
class Plan:
    """What would be if ``run`` became the current run; nothing is written.

    run                 the new run, or what waits of it in the project's folder
    run_name, history   the run that the edits come from, and its history when the plan was made
    outcomes            of every edit that stands or waits, in the order in which they are tried
    lost                edits taken back that could no more be made again
    known               whether the runs share scans: without, no edit can be carried
    """

    run: Run | Staged
    run_name: str
    history: History
    rebased: Rebased
    known: bool

    @property
    def outcomes(self) -> list[Outcome]:
        return self.rebased.outcomes

    @property
    def lost(self) -> list[Outcome]:
        return self.rebased.lost

    @property
    def map(self) -> RGMap:
        """The corrected map of the new run, for a look at it."""
        return self.rebased.history.map

    def counts(self) -> dict[str, int]:
        """How many edits ended how."""
        kinds = [o.kind for o in self.outcomes]
        return {kind: kinds.count(kind) for kind in ("applied", "shifted", "conflict", "stale")}


def plan_rerun(project: Project, run: Run | Staged, leave: Collection[Key] = ()) -> Plan:
    """What would become of the edits of a project on a new run of it. ``leave``: edits that are not to be made.

    The project may be edited meanwhile by another thread: the plan is that of the history when it was begun.
    """
    name, history = project.run_name, project.history
    source = _source(name, history, project, project.trajectory, project.run_info.sha256, run)
    rebased = rebase(source, run.map, _held(project, history, run), leave)
    return Plan(run, name, history, rebased, source.drift.known)


def chosen(plan: Plan, choices: Mapping[int, Choice], project: Project) -> tuple[Sequence[AnyEntry], Sequence[Outcome]]:
    """The journal of the new run under a person's choices, and the edits that are not in it.

    Raises ProjectError for a choice about no outcome, or a remedy that the map refuses.
    """
    wrong = [i for i in choices if not 0 <= i < len(plan.outcomes)]
    if wrong:
        raise ProjectError(f"there is no outcome {wrong[0]} in this plan of {len(plan.outcomes)}")
    leave = {plan.outcomes[i].key for i, choice in choices.items() if choice == LEAVE and not plan.outcomes[i].waits}
    rebased = plan_rerun(project, plan.run, leave).rebased if leave else plan.rebased
    settled = project.history.settled
    gone = [o for o in project.kept if o.key in settled]  # their settling is an entry of the journal and can be undone
    kept = [*gone, *(o for o in rebased.outcomes if o.waits or o.edit is None)]
    remedied = [(plan.outcomes[i], c) for i, c in sorted(choices.items()) if isinstance(c, Remedy)]
    return _with_remedies(rebased, remedied), kept


def _with_remedies(rebased: Rebased, remedied: Sequence[tuple[Outcome, Remedy]]) -> Sequence[AnyEntry]:
    """The journal with the remedies that a person chose, after all that was carried; nothing can be redone then."""
    if not remedied:
        return rebased.entries
    undone = len(rebased.history.undone)
    entries: list[AnyEntry] = list(rebased.entries[: len(rebased.entries) - 2 * undone])
    history, _ = replay(rebased.history.base, entries)
    for outcome, remedy in remedied:
        run, number = outcome.key
        entry = Settle(
            number=len(entries) + 1,
            at=now(),
            by=outcome.entry.by,
            run=run,
            conflict=number,
            name=f"{outcome.title}: {remedy.name}"[:160],
            edit=remedy.edit,
        )
        try:
            history = step(history, entry)
        except EditError as e:
            raise ProjectError(f"{outcome.title}: {remedy.name}: {e}; choose another remedy") from e
        entries.append(entry)
    return [*entries, *_again(history, rebased, len(entries))]


def _again(history: History, rebased: Rebased, count: int) -> list[AnyEntry]:
    """What was taken back, done and taken back once more, so that it can be redone; none if a remedy forbids it."""
    undone = rebased.entries[len(rebased.entries) - 2 * len(rebased.history.undone) :]
    again = [msgspec.structs.replace(e, number=count + 1 + i) for i, e in enumerate(undone)]
    try:
        for entry in again:
            history = step(history, entry)
    except EditError:
        return []
    return again


def _held(project: Project, history: History, run: Run | Staged) -> list[tuple[Source, Done]]:
    """The edits of earlier runs that are not in the journal and not settled, each with the run that it comes from."""
    settled = history.settled
    found: dict[str, Source] = {}
    out = []
    for outcome in project.kept:
        if outcome.key in settled:
            continue
        where = project.path / "runs" / outcome.run
        if outcome.run not in found:
            try:
                history, trajectory = read_run(where)
                sha256 = folder.read_info(where).sha256
            except ProjectError:  # the folder of that run was removed
                history, trajectory, sha256 = History.of(RGMap()), _nowhere(), ""
            found[outcome.run] = _source(outcome.run, history, None, trajectory, sha256, run)
        source = found[outcome.run]
        patch = next((d.patch for d in source.history.done if d.entry.number == outcome.entry.number), ())
        out.append((source, Done(outcome.entry, outcome.title, patch)))
    return out


def read_run(where: Path) -> tuple[History, Trajectory]:
    """What a run's folder holds, without opening the project: edits included. Raises ProjectError."""
    history, _ = replay(folder.read_base(where), Journal(where / "edits.jsonl").entries)
    return history, folder.read_trajectory(where)


def _source(
    name: str, history: History, project: Project | None, trajectory: Trajectory, sha256: str, run: Run | Staged
) -> Source:
    echoes = None if project is None else (project.points, project.point_scans)
    log = run.info if isinstance(run, Staged) else run.log
    return Source(name, history, Drift(trajectory, run.trajectory, sha256 == log.sha256, echoes))


def _nowhere() -> Trajectory:
    return Trajectory(np.zeros(0), np.zeros((0, 3)), np.zeros(3))
