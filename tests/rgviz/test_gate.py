"""The gate: who is let in, what is served, on the real server."""

from __future__ import annotations

import http.client
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import msgspec
import pytest
import viser
import websockets.exceptions
from websockets.sync.client import connect

from rgcore.errors import EditError, RgError
from rgviz import server as server_module
from rgviz.gate import File, Gate, hosts_for, link
from rgviz.server import LARGEST, LARGEST_FILE, Uploads, close_server, may_edit, open_server, patched_page

TOKEN = "a-secret-of-this-test"


class Served:
    """A gated server and what a client needs to talk to it."""

    def __init__(self, static: Path) -> None:
        self.gate = Gate(TOKEN, static=static, page=patched_page("rg <test>", "<script src='/static/app.js'></script>"))
        self.gate.routes["/export/map.json"] = lambda q: File(b'{"a": 1}', "application/json", 'my "map".json')
        self.gate.routes["/refused"] = _refuse
        self.gate.routes["/broken"] = _break
        self.server = open_server(self.gate, "127.0.0.1", 0)
        self.host = f"127.0.0.1:{self.gate.port}"

    def get(self, path: str, **headers: str) -> http.client.HTTPResponse:
        connection = http.client.HTTPConnection("127.0.0.1", self.gate.port, timeout=10)
        connection.putrequest("GET", path, skip_host="Host" in headers)
        for name, value in headers.items():
            connection.putheader(name.replace("_", "-"), value)
        connection.endheaders()
        return connection.getresponse()

    def cookie(self) -> dict[str, str]:
        return {"Cookie": f"{self.gate.cookie}={self.gate.session}"}

    def websocket(self, send: object = None, **headers: str) -> int:
        """101 if a websocket was opened and spoke, else the status of the refusal."""

        origin, path = headers.pop("Origin", None), headers.pop("path", "/")
        protocol: Any = f"viser-v{viser.__version__}"
        try:
            with connect(
                f"ws://{self.host}{path}", origin=origin, additional_headers=headers, subprotocols=[protocol]
            ) as w:
                if send is not None:
                    w.send(msgspec.msgpack.encode(send))
                w.recv(timeout=5)
        except websockets.exceptions.InvalidStatus as e:
            return e.response.status_code
        return 101


def _refuse(_: dict[str, str]) -> File:
    raise EditError("the map is not there yet")


def _break(_: dict[str, str]) -> File:
    raise KeyError("secret detail")


@pytest.fixture(scope="module")
def served(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Served]:
    folder = tmp_path_factory.mktemp("web")
    (folder / "secret.txt").write_text("not for you")
    static = folder / "static"
    static.mkdir()
    (static / "app.js").write_text("window.ours = 1;")
    (static / "favicon.svg").write_text("<svg/>")
    (static / "way-out").symlink_to(folder / "secret.txt")
    s = Served(static)
    yield s
    close_server(s.server)


def test_without_the_token_nothing_is_served(served: Served) -> None:
    for path in ("/", "/index.html", "/static/app.js", "/export/map.json", "/favicon.ico", "/nothing"):
        assert served.get(path).status == 401, path
    assert served.get("/?token=wrong").status == 403
    assert served.get("/", Cookie=f"{served.gate.cookie}=forged").status == 401
    assert served.get("/", Cookie=f"rgviz_1={served.gate.session}").status == 401, "the cookie of another port"
    assert served.get("/", Authorization="Bearer wrong").status == 401
    assert served.get("/", Authorization="Bearer ").status == 401


def test_the_link_gives_a_cookie_that_scripts_and_other_sites_cannot_use(served: Served) -> None:
    answer = served.get(f"/?token={TOKEN}")
    cookie = answer.headers["Set-Cookie"]
    assert answer.status == 200
    assert "HttpOnly" in cookie
    assert "SameSite=Strict" in cookie
    assert TOKEN not in cookie
    assert TOKEN not in answer.read().decode()
    page = served.get("/", Cookie=cookie.split(";")[0])
    assert page.status == 200
    text = page.read().decode()
    assert "<title>rg &lt;test&gt;</title>" in text
    assert "/static/app.js" in text
    assert link(served.gate, "127.0.0.1") == f"http://{served.host}/?token={TOKEN}"


def test_every_answer_carries_the_protecting_headers(served: Served) -> None:
    for path, headers in (("/", served.cookie()), ("/", {}), ("/static/app.js", served.cookie())):
        h = served.get(path, **headers).headers
        assert h["X-Content-Type-Options"] == "nosniff"
        assert h["X-Frame-Options"] == "DENY"
        assert "connect-src 'self'" in h["Content-Security-Policy"]
        assert "frame-ancestors 'none'" in h["Content-Security-Policy"]


def test_static_files_and_downloads(served: Served) -> None:
    answer = served.get("/static/app.js", **served.cookie())
    assert (answer.status, answer.read()) == (200, b"window.ours = 1;")
    assert answer.headers["Content-Type"] == "text/javascript"
    answer = served.get("/export/map.json", Authorization=f"Bearer {TOKEN}")
    assert answer.read() == b'{"a": 1}'
    assert answer.headers["Content-Disposition"] == 'attachment; filename="my _map_.json"'
    refused = served.get("/refused", **served.cookie())
    assert (refused.status, refused.read()) == (409, b"rgviz: the map is not there yet\n")
    broken = served.get("/broken", **served.cookie())
    assert broken.status == 500
    assert b"secret detail" not in broken.read()


@pytest.mark.parametrize(
    "path",
    [
        "/static/../secret.txt",
        "/static/..%2fsecret.txt",
        "/static/%2e%2e/secret.txt",
        "/static//etc/passwd",
        "/static/%2fetc%2fpasswd",
        "/static/way-out",
        "/static/",
        "/static/a%00b",
        "/..%2f..%2f..%2fetc/passwd",
        "/static/..\\secret.txt",
    ],
)
def test_no_path_leads_out_of_the_folder(served: Served, path: str) -> None:
    answer = served.get(path, **served.cookie())
    assert answer.status == 404
    assert b"not for you" not in answer.read()


def test_foreign_hosts_and_pages_are_turned_away(served: Served) -> None:
    for host in ("evil.example", f"evil.example:{served.gate.port}", "127.0.0.1.evil.example", "10.0.0.1", ""):
        assert served.get("/", **served.cookie(), Host=host).status in (400, 421), host
    for origin in ("http://evil.example", "null", f"http://127.0.0.1:{served.gate.port + 1}", "file://"):
        assert served.get("/export/map.json", **served.cookie(), Origin=origin).status == 403, origin
    cross = {"Sec_Fetch_Site": "cross-site", "Sec_Fetch_Mode": "no-cors"}
    assert served.get("/export/map.json", **served.cookie(), **cross).status == 403
    followed = {"Sec_Fetch_Site": "cross-site", "Sec_Fetch_Mode": "navigate"}
    assert served.get("/", **served.cookie(), **followed).status == 200, "a link on another site may lead here"
    for name in ("localhost", "127.0.0.1"):
        assert served.get("/", **served.cookie(), Host=f"{name}:{served.gate.port}").status == 200


def test_parameters_that_connect_the_page_elsewhere_are_off(served: Served) -> None:
    for query in ("websocket=ws://evil.example", "playbackPath=http://evil.example/x.viser", "a=1&websocket="):
        assert served.get(f"/?{query}", **served.cookie()).status == 400
        assert served.get(f"/?{query}&token={TOKEN}").status == 400
    assert served.get("/?fixedDpr=1", **served.cookie()).status == 200


def test_websockets_need_cookie_and_origin(served: Served) -> None:
    ours = f"http://{served.host}"
    assert served.websocket() == 403
    assert served.websocket(Origin=ours) == 401
    assert served.websocket(**served.cookie()) == 403
    assert served.websocket(Origin="http://evil.example", **served.cookie()) == 403
    assert served.websocket(Origin="null", **served.cookie()) == 403
    assert served.websocket(Origin=f"http://127.0.0.1:{served.gate.port + 1}", **served.cookie()) == 403
    assert served.websocket(Origin=ours, Cookie=f"{served.gate.cookie}=forged") == 401
    assert served.websocket(Origin=ours, path=f"/?token={TOKEN}") == 401, "the token of a link opens pages only"
    assert served.websocket(Origin=ours, **served.cookie()) == 101


def test_the_share_tunnel_is_gone(served: Served) -> None:
    ours = {"Origin": f"http://{served.host}", **served.cookie()}
    assert served.websocket(send={"type": "ShareUrlRequest"}, **ours) == 101
    time.sleep(0.3)
    assert served.server._share_tunnel is None
    handlers = served.server._websock_server._incoming_handlers
    assert not [m for m in handlers if "Share" in m.__name__]


def test_junk_does_not_stop_the_server(served: Served) -> None:
    ours = {"Origin": f"http://{served.host}", **served.cookie()}
    update = {"type": "GuiUpdateMessage", "uuid": "x", "updates": {"value": 1}}
    for junk in ({"type": "NoSuchMessage"}, ["x"], update, b"\xff"):
        served.websocket(send=junk, **ours)
    assert served.websocket(**ours) == 101
    assert served.get("/", **served.cookie()).status == 200


def test_ten_thousand_junk_messages_cost_nobody_else_anything(served: Served) -> None:
    ours = {"Origin": f"http://{served.host}", **served.cookie()}
    junk = [
        msgspec.msgpack.encode(m)
        for m in (
            {"type": "GuiUpdateMessage", "uuid": "no-such-field", "updates": {"value": "x" * 500}},
            {"type": "GuiButtonHoldMessage", "uuid": "none", "frequency": 1e9},
            {"type": "ViewerCameraMessage"},
        )
    ]
    with _opened(served) as w:
        for n in range(10_000):
            try:
                w.send(junk[n % len(junk)])
            except websockets.exceptions.ConnectionClosed:
                break
        began = time.monotonic()
        assert served.get("/static/app.js", **served.cookie()).status == 200
        assert time.monotonic() - began < 5, "others had to wait"
    assert served.websocket(**ours) == 101


def test_a_gigabyte_is_not_taken(served: Served) -> None:
    """Neither as viser's upload, with or without its announcement, nor as one message."""
    start = {
        "type": "FileTransferStartUpload",
        "source_component_uuid": "none",
        "transfer_uuid": "t",
        "filename": "../../etc/passwd",
        "mime_type": "text/plain",
        "part_count": 1024,
        "size_bytes": 2**30,
    }
    part = {"type": "FileTransferPart", "source_component_uuid": "none", "transfer_uuid": "t", "part_index": 0}
    megabyte = b"x" * 2**20
    for first, rest in ((start, {**part, "content": megabyte}), ({**part, "content": megabyte},) * 2):
        code, sent = _poured(served, first, *[rest] * 1024)
        assert code == 1008
        assert sent < 100, "a gigabyte was nearly there"
    assert not served.server.gui._current_file_upload_states
    large = {"type": "GuiUpdateMessage", "uuid": "x", "updates": {"value": "x" * LARGEST}}
    assert _poured(served, large)[0] == 1009
    assert served.get("/", **served.cookie()).status == 200


def test_the_link_for_looking_is_another_one_and_forged_ones_are_none(served: Served) -> None:
    gate = served.gate
    assert link(gate, "127.0.0.1", "view") == f"http://{served.host}/?token={gate.view_token}"
    assert gate.view_token not in (gate.token, "")
    cookie = served.get(f"/?token={gate.view_token}").headers["Set-Cookie"].split(";")[0]
    assert cookie == f"{gate.cookie}={gate.view_session}"
    for path in ("/", "/static/app.js", "/export/map.json"):
        assert served.get(path, Cookie=cookie).status == 200
    assert served.get("/", Authorization=f"Bearer {gate.view_token}").status == 200
    for forged in (gate.view_token[:-1], gate.view_session, gate.session, TOKEN.upper(), ""):
        assert served.get(f"/?token={forged}").status == 403, forged
    for forged in (gate.token, gate.view_token, gate.session[:-1]):
        assert served.get("/", Cookie=f"{gate.cookie}={forged}").status == 401, forged


def test_who_came_to_look_is_known_as_long_as_the_browser_is_there(served: Served) -> None:
    def asked(cookie: str) -> set[bool]:
        before = set(served.server._websock_server._live_connections)
        with _opened(served, cookie):
            new = set(served.server._websock_server._live_connections) - before
            return {may_edit(served.server, served.gate, i) for i in new}

    assert asked(f"{served.gate.cookie}={served.gate.session}") == {True}
    assert asked(f"{served.gate.cookie}={served.gate.view_session}") == {False}
    assert not may_edit(served.server, served.gate, 10**6)


def _poured(served: Served, *messages: object) -> tuple[int | None, int]:
    """How the server closes a websocket that sends all this, and how many it took before."""
    sent = 0
    with _opened(served) as w:
        try:
            for m in messages:
                w.send(msgspec.msgpack.encode(m))
                sent += 1
            while True:
                w.recv(timeout=5)
        except websockets.exceptions.ConnectionClosed as e:
            return e.rcvd.code if e.rcvd else None, sent


def _opened(served: Served, cookie: str = "") -> Any:
    """A websocket that has spoken."""
    protocol: Any = f"viser-v{viser.__version__}"
    w = connect(
        f"ws://{served.host}/",
        origin=f"http://{served.host}",  # type: ignore[arg-type]
        additional_headers={"Cookie": cookie} if cookie else served.cookie(),
        subprotocols=[protocol],
        max_size=None,
    )
    w.recv(timeout=5)
    return w


def test_it_fails_closed(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    made: list[viser.ViserServer] = []
    real = viser.ViserServer

    def remember(**kwargs: object) -> viser.ViserServer:
        made.append(real(**kwargs))  # type: ignore[arg-type]
        return made[-1]

    monkeypatch.setattr(server_module.viser, "ViserServer", remember)
    with monkeypatch.context() as m:
        m.setattr(Gate, "login", lambda self, request: None)  # a gate that lets everybody in
        with pytest.raises(RgError, match="nothing is served"):
            open_server(Gate(TOKEN), "127.0.0.1", 0)
    port = made[-1].get_port()
    with pytest.raises(ConnectionError):
        http.client.HTTPConnection("127.0.0.1", port, timeout=2).request("GET", "/")
    monkeypatch.setattr(server_module, "_serve_through", lambda gate, installed: server_module._silence())
    with pytest.raises(RgError, match="did not take the gate"):
        open_server(Gate(TOKEN), "127.0.0.1", 0)


def test_addresses(served: Served) -> None:
    names, any_ip = hosts_for("0.0.0.0")
    open_gate = Gate(TOKEN, names, any_ip)
    assert open_gate._our_host("192.168.1.7:8080")
    assert open_gate._our_host("[fe80::1]:8080")
    assert not open_gate._our_host("evil.example")
    assert link(Gate(TOKEN, port=8080), "0.0.0.0").startswith("http://127.0.0.1:8080/")
    with pytest.raises(RgError, match="cannot listen there"):
        open_server(Gate(TOKEN), "203.0.113.7", 0)


def test_a_file_is_taken_from_who_may_edit_and_no_more_of_it_than_was_said() -> None:
    def start(size: int, id: str = "t") -> bytes:
        return msgspec.msgpack.encode({"type": "FileTransferStartUpload", "transfer_uuid": id, "size_bytes": size})

    def part(size: int, id: str = "t") -> bytes:
        return msgspec.msgpack.encode({"type": "FileTransferPart", "transfer_uuid": id, "content": bytes(size)})

    for taken in ([start(10), part(4), part(6)], [start(5), part(5), start(3, "u"), part(3, "u")], [b"junk"]):
        uploads = Uploads(allowed=True)
        assert [uploads.refuses(m) for m in taken] == [""] * len(taken)
    for refused in (
        [start(LARGEST_FILE + 1)],
        [start(0)],
        [start(-5)],
        [part(1)],
        [start(10), part(11)],
        [start(10), part(10), part(1)],
        [start(10), start(10, "u")],
        [start(10), part(5, "u")],
    ):
        uploads = Uploads(allowed=True)
        assert [bool(uploads.refuses(m)) for m in refused] == [False] * (len(refused) - 1) + [True]
    assert Uploads(allowed=False).refuses(start(10)) == "files are not taken here"
