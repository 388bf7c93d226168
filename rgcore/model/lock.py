"""One process writes to a project; the others learn who it is."""

from __future__ import annotations

import errno
import os
import socket
from pathlib import Path

import msgspec

from rgcore.model.history import now

try:
    import fcntl
except ImportError:  # Windows
    fcntl = None  # type: ignore[assignment]


class Holder(msgspec.Struct, frozen=True):
    """Who holds a project: process id, host, since when (UTC)."""

    pid: int
    host: str
    since: str

    def __str__(self) -> str:
        return f"process {self.pid} on {self.host} since {self.since}"


class Lock:
    """An advisory lock on a file; it ends with the process, however that ends.

    held    this process may write
    holder  who else holds it; None if nobody, or nobody known
    reason  why it is not held, as a sentence with the remedy; "" if it is held
    notes   anything unusual, a line each
    """

    def __init__(self, path: Path) -> None:
        self.held, self.reason = False, ""
        self.holder: Holder | None = None
        self.notes: list[str] = []
        self._fd = -1
        if fcntl is None:
            self.reason = "there are no POSIX locks of files here; to edit, run rgviz in WSL, Linux or macOS"
            return
        try:
            self._fd = os.open(path, os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o644)
        except OSError as e:
            self.reason = f"its folder cannot be written ({e.strerror})"
            return
        try:
            fcntl.flock(self._fd, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError as e:
            if e.errno in (errno.EWOULDBLOCK, errno.EACCES):
                self._held_by_another()
                return
            self.notes.append(f"{path}: this file system cannot lock files: open the project in one process only")
        self.held = True
        self._sign()

    def release(self) -> None:
        if self._fd >= 0:
            os.close(self._fd)
        self._fd, self.held = -1, False
        self.reason = self.reason or "it is closed"

    def _held_by_another(self) -> None:
        try:
            self.holder = msgspec.json.decode(os.pread(self._fd, 1000, 0), type=Holder)
        except (msgspec.DecodeError, OSError, ValueError):
            self.holder = None  # it has only just begun to write its name
        self.reason = f"{self.holder or 'another process'} holds it; close it there to edit here"
        os.close(self._fd)
        self._fd = -1

    def _sign(self) -> None:
        """Write who holds the lock into it; on a full disk it stays anonymous."""
        me = Holder(
            os.getpid(),
            socket.gethostname(),
            now(),
        )
        try:
            os.ftruncate(self._fd, 0)
            os.pwrite(self._fd, msgspec.json.encode(me), 0)
        except OSError as e:
            self.notes.append(f"the lock could not be signed: {e.strerror}")
