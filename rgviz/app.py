"""The app: a gated server, the session behind it, a view for each browser in front of it.

One way round: a browser's event is posted to the editor's thread, a command or tool makes an edit of it, the session
writes and makes it, the scene draws what changed, every browser sees it.
"""

from __future__ import annotations

import functools
import hashlib
import sys
import threading
import time
import webbrowser
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
import viser

from rgcore.config import Config
from rgcore.errors import InputError, ProjectError, RgError
from rgcore.exports.formats import FORMATS, archived, exported
from rgcore.exports.options import Exported
from rgcore.model.backdrops import laid
from rgcore.model.doubt import work_list
from rgcore.model.lint import lint
from rgcore.model.project import Project
from rgcore.model.records import RGMap
from rgcore.scans.backdrop import read_backdrop, read_file
from rgcore.scans.bags import USUAL, Topics, is_bag
from rgviz import overview, status, theme
from rgviz.again import words
from rgviz.again.again import Again
from rgviz.again.others import Others
from rgviz.backdrops import Backdrops
from rgviz.bridge import HEAD
from rgviz.figures import Figures
from rgviz.gate import File, Gate, hosts_for, link, new_token
from rgviz.help import help_page
from rgviz.jobs import Finished, MappingJob, Report
from rgviz.labels import labels
from rgviz.page import furnish
from rgviz.picking import Picker
from rgviz.play.playback import Playback
from rgviz.play.player import Speed
from rgviz.play.source import Source
from rgviz.scene import Scene
from rgviz.server import close_server, open_server, patched_page
from rgviz.session import Latest, Session, Worker
from rgviz.view import View


class App:
    """The editor on a port. ``start`` returns at once; ``stop`` ends everything that it started."""

    def __init__(self, host: str = "127.0.0.1", port: int = 8080, token: str | None = None) -> None:
        self.host = host
        names, any_ip = hosts_for(host)
        self.gate = Gate(token or new_token(), names, any_ip, static_folder(), patched_page(theme.NAME, HEAD))
        for ending in FORMATS:
            self.gate.routes[f"/export/map{ending}"] = functools.partial(self._export, ending)
        self.worker = Worker()
        self.session: Session | None = None
        self.backdrop: Path | None = None
        """a floor plan to lay under the map as soon as there is one"""
        self.job: MappingJob | None = None
        self.failure: str | None = None
        self.views: dict[int, View] = {}
        self.pace = status.Pace()
        self._name = theme.NAME
        self.picker = Latest(Picker)
        self.labels = Latest(lambda m: labels(m, self.scene.artist))
        self.legend = Latest(overview.legend)
        self.findings = Latest(lint)
        self.doubts = Latest(lambda m: work_list(m, self.findings(m)))
        self.edit_titles = Latest(lambda m: self._edit_titles())
        self.figures: Figures | None = None
        self._exporting = threading.Lock()
        self._last_export: tuple[RGMap, str, Exported] | None = None
        self.gate.routes["/help"] = lambda _: File(help_page(static_folder()).encode(), "text/html; charset=utf-8")
        self.server = open_server(self.gate, host, port)
        self.scene = Scene(self.server)
        self.backdrops = Backdrops(self.server.scene, self.worker.post)
        self.playback = Playback(self)
        self.again, self.others = Again(self), Others(self)
        furnish(self)

    # ---- state that views read --------------------------------------------------------------------

    @property
    def url(self) -> str:
        """The address to open; it carries the token."""
        return link(self.gate, self.host)

    @property
    def view_url(self) -> str:
        """The address for those who may look and change nothing."""
        return link(self.gate, self.host, "view")

    @property
    def map(self) -> RGMap:
        return self.session.map if self.session is not None else (self.scene.map or RGMap())

    @property
    def title(self) -> str:
        return self._name

    @property
    def opened(self) -> Session:
        if self.session is None:
            raise ProjectError(
                "This is the log that is being played; go back to the map to edit it."
                if self.playback.aside is not None
                else "The map is still being made; it can be edited as soon as it is done."
            )
        return self.session

    @property
    def read_only(self) -> bool:
        return self.session is None or self.session.project.read_only

    @property
    def undo_title(self) -> str | None:
        return self.session.undo_title if self.session else None

    @property
    def redo_title(self) -> str | None:
        return self.session.redo_title if self.session else None

    # ---- what there is to show --------------------------------------------------------------------

    def open_project(self, path: Path) -> None:
        """Open a project and show it. Raises ProjectError."""
        project = Project.open(path)
        self.worker.post(self.show_project, project)
        self.worker.wait()

    def map_log(self, log: Path, project: Path, config: Config | None = None, topics: Topics = USUAL) -> None:
        """Map a log in a process of its own, show how it goes, then open the project."""
        self._name = log.name.split(".")[0]
        config = config or Config()
        self.job = MappingJob(log, project, config, lambda m: self.worker.post(self._hear_job, m), topics)
        self.worker.post(self.playback.offer, Source(log, project, config, topics))

    def play_log(
        self, log: Path | None, project: Path, speed: Speed, config: Config | None = None, topics: Topics = USUAL
    ) -> None:
        """Play how a log is mapped: into a new project, or beside one that is there. Without ``log`` that one's own.

        Raises ProjectError, also where the log of the project is not found.
        """
        source = Source(log, project, config or Config(), topics) if log is not None else None
        self.playback.speed = speed
        if source is not None:
            self.playback.source = source
            self._name = source.log.name.split(".")[0]
        if source is None or Project.exists(project):
            self.open_project(project)
        if self.playback.source is None:
            raise ProjectError(f"{project}: {self.playback.trouble}")
        self.worker.post(self.playback.start)

    def stop(self) -> None:
        """End the server, the mapping and the project; safe to call twice."""
        if self.job is not None:
            self.job.cancel()
        self.again.stop()
        self.playback.stop()
        self.worker.finish()
        close_server(self.server)
        if self.session is not None:
            self.session.project.close()

    def status_html(self) -> str:
        """What to tell above the buttons: progress, failure, who else holds the project."""
        if self.failure is not None:
            return status.failed(self.failure)
        if self.playback.on:
            return self.playback.status_html()
        if self.session is None:
            return status.progress(self.pace)
        return status.held(self.session.project) + words.status(self.again)

    # ---- on the editor's thread -------------------------------------------------------------------

    def show_project(self, project: Project) -> None:
        session = Session(project)
        session.listen(self._map_changed)
        self.show_session(session)
        self.playback.opened(project)
        self.again.opened(project)
        if self.backdrop is not None:
            self._lay_first(session, self.backdrop)

    def _lay_first(self, session: Session, file: Path) -> None:
        """The plan that the command line named."""
        try:
            data = read_file(file)
            if hashlib.sha256(data).hexdigest() not in {b.sha256 for b in session.map.backdrops.values()}:
                session.lay(laid(session.map, data, file.name), data)
        except RgError as e:
            sys.stderr.write(f"rgviz: {e}\n")

    def show_session(self, session: Session) -> None:
        project = session.project
        self.session = session
        self.figures = Figures(project)
        self.others.forget()
        self.job = None
        self._name = project.name
        self.scene.show_evidence(np.asarray(project.points), np.asarray(project.trajectory.map_from_base)[:, :2])
        self.scene.show(project.map)
        self.backdrops.project = project
        self.backdrops.show(project.map)
        for view in self.views.values():
            view.show_title()
            view.map_changed()
            view.show_extent()

    def failed(self, why: str) -> None:
        """Nothing came of the log."""
        self.failure = why
        sys.stderr.write(f"rgviz: {why}\n")
        for view in self.views.values():
            view.panels.refresh()

    def _map_changed(self, _before: RGMap, after: RGMap) -> None:
        self.scene.show(after)
        self.backdrops.show(after)
        for view in self.views.values():
            view.map_changed()
        self.again.map_changed()

    def _hear_job(self, message: Report | Finished) -> None:
        if isinstance(message, Finished):
            assert self.job is not None
            if message.error is None:
                self.show_project(Project.open(self.job.project))
                return
            self.failed(message.error)
            return
        self._show_report(message)
        for view in self.views.values():
            view.panels.refresh()

    def _show_report(self, report: Report) -> None:
        self.pace.hear(report)
        if report.points is not None and report.path is not None:
            self.scene.show_evidence(report.points, report.path, growing=True)
        if report.map is not None:
            self.scene.show(report.map)
        if report.points is not None or report.map is not None:
            for view in self.views.values():
                view.show_extent()
                view.tell_labels()

    def join(self, client: viser.ClientHandle) -> None:
        with client.atomic():
            view = View(self, client)
            self.playback.join(view)
        self.views[client.client_id] = view

    def leave(self, client: viser.ClientHandle) -> None:
        self.views.pop(client.client_id, None)
        self.playback.leave_browser(client.client_id)

    def ask(self, client_id: int, task: Callable[[View], None]) -> None:
        """Let the editor's thread do something for the browser that asked."""
        view = self.views.get(client_id)
        if view is not None:
            view.post(task, view)

    def _edit_titles(self) -> dict[int, str]:
        """The standing edits by their number in the journal."""
        history = () if self.session is None else self.session.project.history.done
        return {d.entry.number: d.title for d in history}

    def exported(self, ending: str) -> Exported:
        """The map in a format, from any thread: the map of this moment is a value, so no edit disturbs it.

        The last one is kept, for the download and what is told of it ask at the same time. Raises RgError.
        """
        with self._exporting:
            project, last = self.opened.project, self._last_export
            map_ = project.map
            if last is None or last[0] is not map_ or last[1] != ending:
                last = (map_, ending, exported(ending, map_, project.trajectory, stem=self._name))
                self._last_export = last
            return last[2]

    def _export(self, ending: str, _query: dict[str, str]) -> File:
        """A download, on a worker thread of the server."""
        body, packed = archived(ending, self._name, self.exported(ending))
        if packed:
            return File(body, "application/zip", f"{self._name}{ending}.zip")
        return File(body, FORMATS[ending].media_type, f"{self._name}{ending}")


def view(
    path: Path,
    host: str = "127.0.0.1",
    port: int = 8080,
    open_browser: bool = True,
    project_path: Path | None = None,
    config: Config | None = None,
    token: str | None = None,
    topics: Topics = USUAL,
    play: Speed | None = None,
    logs: Sequence[Path] = (),
    against: Sequence[Path] = (),
    backdrop: Path | None = None,
) -> bool:
    """Serve a project, or map a log first, until Ctrl+C; False if the log could not be mapped (stderr says why).

    play     show how the log is mapped, at this speed
    logs     may be mapped again from the page, beside the project's own and those that lie by it
    against  maps to compare with: projects, runs of one, exported maps
    backdrop  a floor plan to lay under the map

    Raises RgError if there is nothing to serve.
    """
    path = Path(path)
    project = path if path.is_dir() and not is_bag(path) else project_path or Path(path.name.split(".")[0] + ".rg")
    if not path.exists():
        raise InputError(path, "there is no such file or project")
    for named in (*logs, *against):
        if not named.exists():
            raise InputError(named, "there is no such file or project")
    if backdrop is not None:
        read_backdrop(read_file(backdrop), str(backdrop))  # a plan that is none is told before a log is mapped
    app = App(host, port, token)
    app.backdrop = backdrop
    app.again.given, app.others.against = tuple(logs), tuple(against)
    try:
        if play is not None:
            app.play_log(None if path == project else path, project, play, config, topics)
        elif (project / "current").exists() or (path.is_dir() and not is_bag(path)):
            app.open_project(project)
        else:
            app.map_log(path, project, config, topics)
        sys.stdout.write(f"{app.title}: open {app.url}\nto look only: {app.view_url}\nCtrl+C stops it.\n")
        sys.stdout.flush()
        if open_browser:
            threading.Thread(target=webbrowser.open, args=(app.url,), daemon=True).start()
        while app.failure is None or app.views:  # a failure stays on the page as long as somebody looks on
            time.sleep(0.2)
        return False
    finally:
        app.stop()


def static_folder() -> Path:
    """``static/`` of the installed package, or of the checkout."""
    here = Path(__file__).parent
    return here / "static" if (here / "static").is_dir() else here.parent / "static"
