"""The maps that the one on show can be compared with: the new run, earlier runs, what was named with ``--against``."""

from __future__ import annotations

import logging
import threading
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from rgcore.errors import RgError, one_line
from rgcore.exports.rgjson import read_json
from rgcore.model import folder
from rgcore.model.project import Project
from rgcore.model.records import RGMap
from rgcore.model.rerun import read_run
from rgcore.slam.trajectory import Trajectory
from rgviz.again.comparing import Comparison

if TYPE_CHECKING:
    from rgviz.app import App

log = logging.getLogger(__name__)
NEW = "new"
"""key of the new run that waits"""
MOST = 12
"""earlier runs that are offered, the last ones"""


class Others:
    """Comparisons by a key of their own; browsers name no paths. All methods run on the editor's thread."""

    def __init__(self, app: App) -> None:
        self.app = app
        self.against: tuple[Path, ...] = ()
        self.trouble = ""
        self._known: dict[str, Comparison] = {}
        self._tried: dict[str, RGMap] = {}
        self._under_way: set[str] = set()

    @property
    def titles(self) -> dict[str, str]:
        """What there is to compare with, by key."""
        if self.app.session is None:
            return {}
        project = self.app.session.project
        out = {NEW: "the new run"} if self.app.again.proposal is not None else {}
        out |= {f"against {n}": str(path.name) for n, path in enumerate(self.against)}
        return out | {f"run {name}": f"run {int(name)}" for name in _earlier(project)}

    def comparison(self, key: str) -> Comparison | None:
        """What is different, as far as it is known; what is not known of the map as it is now is found out then."""
        if key == NEW:
            proposal = self.app.again.proposal
            return None if proposal is None else proposal.comparison
        known, project = self._known.get(key), self.app.opened.project
        if self._tried.get(key) is not project.map and key not in self._under_way:
            self._under_way.add(key)
            self._tried[key] = project.map
            threading.Thread(target=self._compare, args=(key, project), name="rgviz diff", daemon=True).start()
        return known

    def forget(self) -> None:
        """Another run is on show."""
        self._known, self._tried, self.trouble = {}, {}, ""

    def _compare(self, key: str, project: Project) -> None:
        found: Comparison | str
        try:
            map_, trajectory = project.map, project.trajectory
            found = Comparison.of(self._title(key), *self._read(key, project, map_, trajectory))
        except RgError as e:
            found = one_line(e)
        except Exception:
            log.exception("the maps could not be compared")
            found = "The maps could not be compared: a fault in rgviz. The terminal says more."
        self.app.worker.post(self._found, key, project, found)

    def _title(self, key: str) -> str:
        kind, _, rest = key.partition(" ")
        return self.against[int(rest)].name if kind == "against" else f"run {int(rest)}"

    def _read(
        self, key: str, project: Project, map_: RGMap, trajectory: Trajectory
    ) -> tuple[RGMap, RGMap, Trajectory | None, Trajectory]:
        kind, _, rest = key.partition(" ")
        path = self.against[int(rest)] if kind == "against" else project.path / "runs" / rest
        old, before = read_map(path)
        return old, map_, before, trajectory

    def _found(self, key: str, project: Project, found: Comparison | str) -> None:
        self._under_way.discard(key)
        session = self.app.session
        if session is None or session.project is not project:
            return
        if isinstance(found, Comparison):
            self._known[key] = found
        self.trouble = found if isinstance(found, str) else ""
        for view in self.app.views.values():
            view.again_changed()


def _earlier(project: Project) -> Sequence[str]:
    """Names of the runs before the current one, the last first."""
    names = sorted(p.name for p in (project.path / "runs").glob("[0-9]*") if p.name < project.run_name)
    return names[::-1][:MOST]


def read_map(path: Path) -> tuple[RGMap, Trajectory | None]:
    """The corrected map and the trajectory (None if unknown) of a project, a run of one, or an exported map.

    Raises RgError.
    """
    if path.suffix == ".json" or path.is_file():
        return read_json(path), None
    if path.parent.name == "runs" and (path / "base.json").exists():
        folder.check(path.parent.parent)
    else:
        folder.check(path)
        path = path / "runs" / folder.current(path)
    history, trajectory = read_run(path)
    return history.map, trajectory
