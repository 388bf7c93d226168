"""The gate: every HTTP request and every websocket handshake passes here before viser sees it.

viser alone has no login and asks nobody where they come from: any web page that the user has open could drive the
editor, and a crafted link could load a foreign script into our page. So, on the one port that serves everything:

* the ``Host`` must be ours (DNS rebinding), the ``Origin`` of a websocket must be that host (a foreign page);
* the printed link carries a token; it is exchanged for a strict, script-proof cookie, asked for ever after;
* the URL parameters that make viser's page connect elsewhere are refused, and a policy header (CSP) forbids it too;
* a second link carries another token: who comes by it may look and download, nothing else;
* ``static/`` and the downloads come from here as well.

:mod:`rgviz.server` puts it in front of viser.
"""

from __future__ import annotations

import asyncio
import contextlib
import gzip
import hashlib
import hmac
import http
import ipaddress
import logging
import mimetypes
import re
import secrets
import socket
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from http.cookies import CookieError, SimpleCookie
from pathlib import Path
from typing import Literal
from urllib.parse import parse_qsl, unquote, urlsplit

from websockets.datastructures import Headers
from websockets.http11 import Request, Response

from rgcore.errors import RgError

log = logging.getLogger(__name__)

LOOPBACK = frozenset({"127.0.0.1", "localhost", "[::1]"})
ANY_ADDRESS = frozenset({"0.0.0.0", "::", ""})
FORBIDDEN_PARAMETERS = frozenset({"websocket", "playbackPath"})
"""They make viser's page talk to another server, whose answers may carry scripts."""

HEADERS = {
    "X-Content-Type-Options": "nosniff",
    "X-Frame-Options": "DENY",
    "Referrer-Policy": "no-referrer",
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cross-Origin-Resource-Policy": "same-origin",
    # viser's client is one file of inline script that uses new Function(), wasm and blob workers
    "Content-Security-Policy": (
        "default-src 'self' 'unsafe-inline' 'unsafe-eval' blob: data:; connect-src 'self' blob: data:; "
        "object-src 'none'; base-uri 'none'; form-action 'self'; frame-ancestors 'none'"
    ),
}

_LOGIN = """<!doctype html><meta charset="utf-8"><title>rgviz</title><script>
const u = new URL(location.href); u.searchParams.delete("token"); location.replace(u.pathname + u.search);
</script><noscript><a href="./">Open the map</a></noscript>"""


@dataclass(frozen=True)
class File:
    """What a route answers: a body, its media type and, for a download, the name to save it under."""

    body: bytes
    media_type: str
    name: str | None = None


Role = Literal["edit", "view"]
"""What a link allows: to correct the map, or to look at it."""

Route = Callable[[dict[str, str]], File]
"""From the URL's parameters to a file. Runs on a worker thread; an ``RgError`` becomes a readable 409."""


@dataclass
class Gate:
    """Who may come in, and what is served beside viser's own page.

    token   secret of the link; ``port`` is known once the server listens and names the cookie
    hosts   lower-case names and addresses that a ``Host`` header may hold
    any_ip  whether any IP address will do as ``Host`` (the server listens on all addresses)
    """

    token: str
    hosts: frozenset[str] = LOOPBACK
    any_ip: bool = False
    static: Path | None = None
    page: bytes | None = None
    port: int = 0
    routes: dict[str, Route] = field(default_factory=dict)

    @property
    def cookie(self) -> str:
        return f"rgviz_{self.port}"

    @property
    def view_token(self) -> str:
        """The secret of the link for looking: it follows from the token, and the token does not follow from it."""
        return self._derived("rgviz view")[:32]

    @property
    def session(self) -> str:
        """What the cookie holds: derived, so that with a fixed token an open tab survives a restart."""
        return self._derived("rgviz session")

    @property
    def view_session(self) -> str:
        """What the cookie of the link for looking holds."""
        return self._derived("rgviz view session")

    def role(self, request: Request) -> Role | None:
        """What the cookie of a request, or the token that it bears, allows; None: nothing."""
        cookie, bearer = self._cookie_of(request), "".join(request.headers.get_all("Authorization"))
        roles: tuple[tuple[Role, str, str], ...] = (
            ("edit", self.session, self.token),
            ("view", self.view_session, self.view_token),
        )
        for role, session, token in roles:
            if _same(cookie, session) or _same(bearer, f"Bearer {token}"):
                return role
        return None

    def _derived(self, purpose: str) -> str:
        return hmac.new(self.token.encode(), purpose.encode(), hashlib.sha256).hexdigest()

    def refuse(self, request: Request) -> Response | None:
        """The answer that turns a request away, or None if it may pass (websocket handshakes included)."""
        headers = request.headers
        host_lines = headers.get_all("Host")
        if len(host_lines) != 1:
            return _refusal(400, "exactly one Host header, please")
        host = host_lines[0].lower()
        if not self._our_host(host):
            return _refusal(421, "this server does not answer to that name")
        origins = headers.get_all("Origin")
        if is_websocket(request) and len(origins) != 1:
            return _refusal(403, "a websocket must say which page it comes from")
        if any(not _same_origin(o, host) for o in origins):
            return _refusal(403, "the request comes from another page")
        if headers.get("Sec-Fetch-Site") == "cross-site" and headers.get("Sec-Fetch-Mode") != "navigate":
            return _refusal(403, "the request comes from another site")
        if FORBIDDEN_PARAMETERS & {k for k, _ in _parameters(request)}:
            return _refusal(400, "that URL parameter is switched off here")
        return None

    def login(self, request: Request) -> Response | None:
        """The answer to a request that shows the token or shows nothing; None if its cookie is good."""
        shown = dict(_parameters(request)).get("token")
        if shown is not None and not is_websocket(request):
            if _same(shown, self.token):
                session = self.session
            elif _same(shown, self.view_token):
                session = self.view_session
            else:
                return _refusal(403, "that token is not (or no longer) valid; open the link that rgviz printed")
            # a page that moves on by itself, not a redirect: a strict cookie is not sent on one begun elsewhere
            cookie = f"{self.cookie}={session}; Path=/; HttpOnly; SameSite=Strict"
            return _answer(200, _LOGIN.encode(), "text/html; charset=utf-8", {"Set-Cookie": cookie})
        if self.role(request) is not None:
            return None
        return _refusal(401, "open the link that rgviz printed when it started; it carries the key")

    async def answer(self, request: Request) -> Response | None:
        """Files of ours: the page, ``/static/...``, the routes. None leaves the request to viser."""
        path = unquote(urlsplit(request.path).path)
        if path in ("/", "/index.html") and self.page is not None:
            return self._page(request)
        if path in self.routes:
            return await self._route(path, dict(_parameters(request)))
        if path.startswith("/static/"):
            return self._static(path.removeprefix("/static/"))
        if path == "/favicon.ico":
            return self._static("favicon.svg")
        return None

    def _our_host(self, host: str) -> bool:
        name = re.sub(r":\d+$", "", host)
        if name in self.hosts:
            return True
        return self.any_ip and _is_ip(name.strip("[]"))

    def _cookie_of(self, request: Request) -> str:
        jar: SimpleCookie = SimpleCookie()
        with contextlib.suppress(CookieError):
            jar.load("; ".join(request.headers.get_all("Cookie")))
        return jar[self.cookie].value if self.cookie in jar else ""

    def _page(self, request: Request) -> Response:
        assert self.page is not None
        if "gzip" in request.headers.get("Accept-Encoding", ""):
            return _answer(200, self.page, "text/html; charset=utf-8", {"Content-Encoding": "gzip"})
        return _answer(200, gzip.decompress(self.page), "text/html; charset=utf-8")

    def _static(self, name: str) -> Response:
        if self.static is not None and "\0" not in name:
            file = (self.static / name).resolve()
            if file.is_relative_to(self.static.resolve()) and file.is_file():
                media = "text/javascript" if file.suffix == ".js" else mimetypes.guess_type(file.name)[0]
                return _answer(200, file.read_bytes(), media or "application/octet-stream")
        return _refusal(404, "no such file")

    async def _route(self, path: str, query: dict[str, str]) -> Response:
        try:
            file = await asyncio.get_running_loop().run_in_executor(None, self.routes[path], query)
        except RgError as e:
            return _refusal(409, str(e))
        except Exception:
            log.exception("%s failed", path)
            return _refusal(500, "this download failed; the terminal that runs rgviz says why")
        extra = {"Content-Disposition": f'attachment; filename="{_plain(file.name)}"'} if file.name else {}
        return _answer(200, file.body, file.media_type, extra)


def is_websocket(request: Request) -> bool:
    return any(v.strip().lower() == "websocket" for line in request.headers.get_all("Upgrade") for v in line.split(","))


def hosts_for(host: str) -> tuple[frozenset[str], bool]:
    """Names that a ``Host`` header may hold for a server bound to ``host``, and whether any IP address will do.

    An address can not be rebound by DNS, so it is safe to accept any when the server listens on all of them.
    """
    if host in ANY_ADDRESS:
        return LOOPBACK | {socket.gethostname().lower(), socket.getfqdn().lower()}, True
    return LOOPBACK | {host.lower(), f"[{host.lower()}]"}, False


def link(gate: Gate, host: str, role: Role = "edit") -> str:
    """The address to open, token included."""
    name = "127.0.0.1" if host in ANY_ADDRESS else f"[{host}]" if ":" in host else host
    return f"http://{name}:{gate.port}/?token={gate.token if role == 'edit' else gate.view_token}"


def new_token() -> str:
    return secrets.token_urlsafe(24)


def _parameters(request: Request) -> list[tuple[str, str]]:
    return parse_qsl(urlsplit(request.path).query, keep_blank_values=True)


def _same_origin(origin: str, host: str) -> bool:
    parts = urlsplit(origin)
    return parts.scheme in ("http", "https") and parts.netloc.lower() == host


def _same(a: str, b: str) -> bool:
    return hmac.compare_digest(a.encode(errors="replace"), b.encode(errors="replace"))


def _is_ip(name: str) -> bool:
    try:
        ipaddress.ip_address(name)
    except ValueError:
        return False
    return True


def _plain(name: str) -> str:
    """A file name without anything that a header or a disk could take amiss."""
    return re.sub(r"[^\w.\- ]", "_", name, flags=re.ASCII)


def _answer(status: int, body: bytes, media_type: str, extra: Mapping[str, str] | None = None) -> Response:
    lines = {"Content-Type": media_type, "Content-Length": str(len(body)), "Cache-Control": "no-store"}
    code = http.HTTPStatus(status)
    return Response(code.value, code.phrase, Headers({**lines, "Connection": "close", **(extra or {})}), body)


def _refusal(status: int, why: str) -> Response:
    return _answer(status, f"rgviz: {why}\n".encode(), "text/plain; charset=utf-8")


def with_headers(response: Response) -> Response:
    for name, value in HEADERS.items():
        if name not in response.headers:
            response.headers[name] = value
    return response
