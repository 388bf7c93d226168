"""A viser server behind the gate. It fails closed: if viser did not take the gate, or a request without a token is not
turned away, nothing is served."""

from __future__ import annotations

import contextlib
import gzip
import html
import inspect
import io
import re
import socket
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import msgspec
import viser
import viser._messages
import websockets.asyncio.server
from websockets.http11 import Request, Response

import rgcore.scans.backdrop
from rgcore.errors import RgError
from rgviz.gate import Gate, is_websocket, with_headers

LARGEST = 4 * 2**20
"""bytes of one message from a browser; those of the page are a few kilobytes"""
LARGEST_FILE = rgcore.scans.backdrop.LARGEST
"""bytes of a file that a browser may bring: floor plans, nothing else"""

_serve_lock = threading.Lock()


class _Message(msgspec.Struct):
    """What of a message of viser that brings a file is looked at."""

    type: str = ""
    transfer_uuid: str = ""
    size_bytes: int = 0
    content: bytes = b""


def patched_page(title: str, head: str) -> bytes:
    """viser's page (one gzipped HTML file) with our title, icon and ``head`` (HTML) in it."""
    source = (Path(viser.__file__).parent / "client" / "build" / "index.html").read_text(encoding="utf-8")
    source, titles = re.subn(r"<title>[^<]*</title>", f"<title>{html.escape(title)}</title>", source, count=1)
    icon = '<link rel="icon" type="image/svg+xml" href="/static/favicon.svg">'
    source, _ = re.subn(r'<link\s+rel="icon"[^>]*>', "", source, flags=re.S)
    at = source.find("</head>")
    if titles != 1 or at < 0:
        raise RgError("this version of viser is not the one rgviz was made for; install viser==1.1.1")
    return gzip.compress((source[:at] + icon + head + source[at:]).encode(), 6)


def open_server(gate: Gate, host: str, port: int) -> viser.ViserServer:
    """A viser server behind the gate, listening. If the port is taken, the next free one is used.

    Raises RgError if the address cannot be bound, or if viser did not take the gate (nothing is served then).
    """
    _check_address(host)
    installed: list[bool] = []
    with _serve_lock, _serve_through(gate, installed), _silence():
        server = viser.ViserServer(host=host, port=port, verbose=False)
    gate.port = server.get_port()
    try:
        if installed != [True]:
            raise RgError("viser did not take the gate; rgviz needs viser==1.1.1")
        for message in (viser._messages.ShareUrlRequest, viser._messages.ShareUrlDisconnect):
            server._websock_server.unregister_handler(message)
        _try_to_break_in(host, gate.port)
    except BaseException:
        close_server(server)
        raise
    return server


def may_edit(server: viser.ViserServer, gate: Gate, client_id: int) -> bool:
    """Whether a browser came by the link that allows edits; one that cannot be asked any more did not."""
    connection = server._websock_server._live_connections.get(client_id)
    request = None if connection is None else connection.request
    return request is not None and gate.role(request) == "edit"


def close_server(server: viser.ViserServer) -> None:
    with _silence():
        server.stop()


@contextlib.contextmanager
def _serve_through(gate: Gate, installed: list[bool]) -> Iterator[None]:
    """While it lasts, what viser gives ``websockets`` to serve goes through the gate."""
    original = websockets.asyncio.server.serve

    def serve(*args: Any, process_request: Any = None, **rest: Any) -> Any:
        async def guarded(connection: Any, request: Request) -> Response | None:
            answer = gate.refuse(request) or gate.login(request)
            if answer is None and not is_websocket(request):
                answer = await gate.answer(request)
            if answer is None:
                answer = process_request(connection, request)
                if inspect.isawaitable(answer):
                    answer = await answer
            if answer is None and is_websocket(request):
                _limit_uploads(connection, gate.role(request) == "edit")
            return None if answer is None else with_headers(answer)

        if not installed:
            installed.append(process_request is not None)
        return original(*args, process_request=guarded, **{**rest, "max_size": LARGEST})

    websockets.asyncio.server.serve = serve  # type: ignore[misc, assignment]
    try:
        yield
    finally:
        websockets.asyncio.server.serve = original  # type: ignore[misc]


class Uploads:
    """The files that one browser brings: one after the other, and never more of one than it said, or than is taken.

    viser keeps all parts in memory until the last is there, as many as anybody sends.
    """

    def __init__(self, allowed: bool) -> None:
        self._allowed = allowed
        self._id, self._left = "", 0

    def refuses(self, message: Any) -> str:
        """Why a message is not taken; "" if it may pass."""
        try:
            m = msgspec.msgpack.decode(message, type=_Message)
        except (msgspec.DecodeError, TypeError):
            return ""  # anything else that is wrong with it viser finds out itself
        if m.type not in ("FileTransferStartUpload", "FileTransferPart"):
            return ""
        if not self._allowed:
            return "files are not taken here"
        if m.type == "FileTransferStartUpload":
            if self._left or not 0 < m.size_bytes <= LARGEST_FILE:
                return f"one file at a time, of at most {LARGEST_FILE >> 20} MB"
            self._id, self._left = m.transfer_uuid, m.size_bytes
            return ""
        if m.transfer_uuid != self._id or not 0 < len(m.content) <= self._left:
            return "a file that is larger than it said"
        self._left -= len(m.content)
        return ""


def _limit_uploads(connection: Any, allowed: bool) -> None:
    """Close a websocket that brings what it must not."""
    receive, uploads = connection.recv, Uploads(allowed)

    async def checked(*args: Any, **rest: Any) -> Any:
        message = await receive(*args, **rest)
        if why := uploads.refuses(message):
            await connection.close(1008, f"rgviz: {why}")
            return await receive(*args, **rest)  # raises that the connection is closed
        return message

    connection.recv = checked


@contextlib.contextmanager
def _silence() -> Iterator[None]:
    """viser prints a link without the token; ours is the one that works."""
    with contextlib.redirect_stdout(io.StringIO()):
        yield


def _check_address(host: str) -> None:
    """viser would try a thousand ports and then hang."""
    try:
        family, kind, protocol, _, address = socket.getaddrinfo(host or None, 0, type=socket.SOCK_STREAM)[0]
        with socket.socket(family, kind, protocol) as probe:
            probe.bind(address)
    except OSError as e:
        raise RgError(f"--host {host}: cannot listen there ({e.strerror or e}); 127.0.0.1 always works") from e


def _try_to_break_in(host: str, port: int) -> None:
    """Ask without a token, as a page and as a websocket; anything but a refusal stops the server."""
    target = {"0.0.0.0": "127.0.0.1", "": "127.0.0.1", "::": "::1"}.get(host, host)
    upgrade = "Upgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Version: 13\r\n"
    socket_lines = upgrade + "Sec-WebSocket-Key: cmd2aXogc2VsZiB0ZXN0IQ==\r\n"
    for lines in ("", socket_lines, socket_lines + f"Origin: http://127.0.0.1:{port}\r\n"):
        with socket.create_connection((target, port), 10) as s:
            s.sendall(f"GET / HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\n{lines}\r\n".encode())
            status = s.recv(64).split()
        if len(status) < 2 or status[1] not in (b"401", b"403"):
            raise RgError("the gate does not hold: a request without the token was let in; nothing is served")
