"""Playing the mapping of a log in the app: one playback for all browsers, held by the server."""

from __future__ import annotations

import threading
import time
from typing import TYPE_CHECKING

import numpy as np

from rgcore.model.project import Project
from rgviz import status
from rgviz.jobs import Finished, Report
from rgviz.markup import wrap
from rgviz.play.child import Mapped, Message, Opening, Picture, PlayJob
from rgviz.play.controls import Controls, told
from rgviz.play.player import SPEEDS, Player, Speed
from rgviz.play.source import Source, find_log
from rgviz.play.stage import Stage, map_so_far, names_in
from rgviz.play.tape import Tape

if TYPE_CHECKING:
    from rgviz.app import App
    from rgviz.session import Session
    from rgviz.view import View

BEAT, REST = 0.2, 0.05
"""s between two moments that are shown, and at least so much rest for everybody else between them"""
PICTURE_EVERY, PICTURE_SOUGHT = 1.0, 0.25
"""s between two pictures of the map that are sent, while it plays, and while a hand seeks"""


class Playback:
    """``on``: the playback is on show, not the map. Methods run on the editor's thread, but for ``stop``."""

    def __init__(self, app: App) -> None:
        self.app = app
        self.on = False
        self.source: Source | None = None
        self.player: Player | None = None
        self.speed: Speed = "4x"
        self.aside: Session | None = None
        """the project that is open behind it"""
        self.stage = Stage(app.scene)
        self.controls = Controls(self)
        self._job: PlayJob | None = None
        self._number = 0  # of the job
        self._made = False  # the project of the log is made, but not open yet
        self.trouble = ""
        self._names: dict[str, str] = {}
        self._shown: Picture | None = None
        self._drawn = (-1, 0.0)  # scan on show, and when the last picture was sent
        self._extent: np.ndarray | None = None
        self._followers: set[int] = set()
        self._last = time.monotonic()
        self._wake, self._over = threading.Event(), threading.Event()
        self._clock: threading.Thread | None = None

    # ---- told by the app --------------------------------------------------------------------------

    def offer(self, source: Source | None) -> None:
        """A log that can be played from now on."""
        if source is not None:
            self.source = source
        self.refresh()

    def opened(self, project: Project) -> None:
        """A project was opened: its log can be played if it is found."""
        self.source, self.trouble = find_log(project, self.source)
        self.refresh()

    def join(self, view: View) -> None:
        self.controls.add_follow(view)
        self.refresh()

    def leave_browser(self, client_id: int) -> None:
        self._followers.discard(client_id)
        self.controls.forget(client_id)

    def status_html(self) -> str:
        """How far the mapping is where no scan tells it: reading the log, and what follows the last scan."""
        mapping = self._job is not None and self._job.project is not None
        at_end = self.player is not None and len(self.player.tape) == self.player.tape.total
        return status.progress(self.app.pace) if self.player is None or (mapping and at_end) else ""

    def stop(self) -> None:
        """End all that it started."""
        self._over.set()
        self._wake.set()
        if self._job is not None:
            self._job.cancel()
        if self._clock is not None:
            self._clock.join(timeout=5)
        if self.aside is not None:
            self.aside.project.close()

    # ---- asked for by people ----------------------------------------------------------------------

    def start(self) -> None:
        """Play the log: the tape, if all of it is there, else a new mapping."""
        if self.source is None or self.on:
            return
        app = self.app
        if app.job is not None:
            app.job.cancel()
            app.job = None
        self.on, self.aside, app.session = True, app.session, None
        app.pace = status.Pace(again=self.aside is not None)
        self.trouble, self._shown, self._drawn, self._extent = "", None, (-1, 0.0), None
        app.scene.show_evidence(np.zeros((0, 2), np.float32), np.zeros((0, 2)))
        app.scene.show(map_so_far(EMPTY, {}))
        if self.player is not None:
            self.player.seek(0)
            self.player.playing = True
        else:
            s = self.source
            number = self._number = self._number + 1
            self._job = PlayJob(s.log, s.project, s.config, lambda m: self._post(number, m), s.topics, s.sha256)
        if self._clock is None:
            self._clock = threading.Thread(target=self._run, name="rgviz clock", daemon=True)
            self._clock.start()
        self._all_views()

    def leave(self) -> None:
        """Back to the map."""
        if not self.on or (self.aside is None and not self._made):
            return
        if self._job is not None:
            self._job.cancel()
        if self.player is not None and len(self.player.tape) < self.player.tape.total:
            self.player = None
        self._job, self.on = None, False
        self.stage.clear()
        if self._made and self.source is not None and self.source.project is not None:
            self._made = False
            self.app.show_project(Project.open(self.source.project))
        elif self.aside is not None:
            session, self.aside = self.aside, None
            self.app.show_session(session)
        self.refresh()

    def toggle(self) -> None:
        if self.player is not None:
            self.player.pause() if self.player.busy else self.player.play()
            self._soon()

    def seek(self, scan: int) -> None:
        if self.player is not None:
            self.player.seek(scan)
            self._soon()

    def step(self, scans: int) -> None:
        if self.player is not None:
            self.player.step(scans)
            self._soon()

    def set_speed(self, speed: str) -> None:
        if speed in SPEEDS:
            self.speed = speed
            if self.player is not None:
                self.player.speed = self.speed
                self._soon()

    def follow(self, client_id: int, follows: bool) -> None:
        (self._followers.add if follows else self._followers.discard)(client_id)
        self._look()

    # ---- the child --------------------------------------------------------------------------------

    def _post(self, number: int, message: Message) -> None:
        self.app.worker.post(self._hear, number, message)

    def _hear(self, number: int, message: Message) -> None:
        if number != self._number or self._job is None:
            return  # of one that was left
        if isinstance(message, Opening):
            self.player = Player(Tape(message), self.speed, playing=True)
        elif isinstance(message, Report):
            self.app.pace.hear(message)
            self._all_views()
        elif isinstance(message, Finished):
            self._ended(message)
        elif self.player is not None:
            if isinstance(message, Mapped):
                self.player.tape.add(message)
            else:
                self.player.tape.draw(message)

    def _ended(self, message: Finished) -> None:
        if message.error is not None and self.aside is None:
            self.app.failed(message.error)
        elif message.error is not None:
            self.leave()
            self.trouble = message.error
            self.refresh()
        else:
            self._made = self._job is not None and self._job.project is not None
            self._job = None
            self._soon()

    # ---- as time goes by --------------------------------------------------------------------------

    def _run(self) -> None:
        """A beat as long as there is something to show, sooner where somebody pressed something."""
        while not self._over.is_set():
            self._wake.wait(BEAT)
            self._wake.clear()
            done = threading.Event()
            self.app.worker.post(self._beat, done)
            done.wait(timeout=10)
            self._over.wait(REST)

    def _soon(self) -> None:
        self._wake.set()

    def _beat(self, done: threading.Event) -> None:
        try:
            self.tick(time.monotonic())
        finally:
            done.set()

    def tick(self, now: float) -> None:
        """Show what is to be seen at ``now`` [s of a clock that only runs forward]."""
        seconds, self._last = min(now - self._last, 1.0), now
        if not self.on or self.player is None:
            return
        player = self.player
        player.tick(seconds)
        if self._job is not None:
            self._job.allow(player.wanted)
        if player.ended and self._made:
            self.leave()
            return
        changed = self._draw_picture(now)
        if changed or player.at != self._drawn[0]:
            self._drawn = (player.at, self._drawn[1])
            if player.at >= 0:
                width = 0.0 if self._extent is None else float(np.ptp(self._extent, axis=0).max())
                self.stage.show(player.tape, player.at, self._shown, width)
                self._look()
        self.refresh()

    def _draw_picture(self, now: float) -> bool:
        """Show the map as it was, if that is another one and the last one is long enough ago."""
        assert self.player is not None
        picture = self.player.tape.picture(self.player.at)
        sought = not self.player.playing or (self._shown is not None and self._shown.scan > self.player.at)
        if picture is self._shown or now - self._drawn[1] < (PICTURE_SOUGHT if sought else PICTURE_EVERY):
            return False
        self._shown, self._drawn = picture, (self._drawn[0], now)
        picture = picture or EMPTY
        self._names = names_in(picture, self.aside.map) if self.aside is not None else {}
        self.app.scene.show_evidence(picture.points, picture.path)
        self.app.scene.show(map_so_far(picture, self._names))
        for view in self.app.views.values():
            view.map_changed()
        self._tell_extent()
        return True

    def _tell_extent(self) -> None:
        """What there is to see, with room to grow, so that the picture does not move with every metre."""
        low, high = self.app.scene.extent
        if self._extent is not None and (low >= self._extent[0]).all() and (high <= self._extent[1]).all():
            return
        pad = 0.15 * (high - low)
        self._extent = np.array([low - pad, high + pad])
        for view in self.app.views.values():
            view.bridge.tell("extent", extent=self._extent.tolist())

    def _look(self) -> None:
        """Take those along who follow the robot."""
        if self.player is None or self.player.at < 0 or not self.on:
            return
        x, y = self.player.tape.pose(self.player.at)[:2].tolist()
        for client_id in self._followers & self.app.views.keys():
            self.app.views[client_id].bridge.tell("look", x=x, y=y)

    def refresh(self) -> None:
        """The controls as things are now."""
        if self.on and self.player is not None:
            leave = "Back to the map" if self.aside is not None else ("Open the map" if self._made else None)
            self.controls.show(told(self.player, self._names), None, self.player, leave)
            return
        if self.on:
            self.controls.show("", None, None, "Back to the map" if self.aside is not None else None)
            return
        trouble = wrap(f'<div class="muted">{status.escape(self.trouble)}</div>') if self.trouble else ""
        start = None if self.source is None else "Play the log instead" if self.app.job is not None else "Play the log"
        self.controls.show("", start, None, None, missing=trouble)

    def _all_views(self) -> None:
        self.refresh()
        for view in self.app.views.values():
            view.map_changed()


EMPTY = Picture(-1, 0, np.zeros((0, 2), np.float32), np.zeros((0, 2), np.float32), (), ())
