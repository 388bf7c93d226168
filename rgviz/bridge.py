"""Between Python and ``static/rgviz.js`` in one browser: there by viser's script message, back by a hidden field."""

from __future__ import annotations

from collections.abc import Callable
from typing import Annotated, Any, Literal

import msgspec
import viser
import viser._messages
from msgspec import Meta

HEAD = '<link rel="stylesheet" href="/static/rgviz.css">' + "".join(
    f'<script src="/static/{name}.js" defer></script>' for name in ("rgviz", "gestures", "seeing")
)
"""What the page must hold for the bridge to stand."""


class Commit(msgspec.Struct, frozen=True, tag="commit", tag_field="type"):
    """A text or number field is finished: Enter was pressed, or the field left."""

    field: Annotated[str, Meta(max_length=100)]
    value: Annotated[str, Meta(max_length=1000)]


class Revert(msgspec.Struct, frozen=True, tag="revert", tag_field="type"):
    """Escape was pressed in a field."""

    field: Annotated[str, Meta(max_length=100)]


Coordinate = Annotated[float, Meta(ge=-1e5, le=1e5)]


class Pointer(msgspec.Struct, frozen=True, tag="pointer", tag_field="type"):
    """The hand does something on the floor of the map: where [m], and what a pixel covers there [m]."""

    kind: Literal["press", "move", "release"]
    x: Coordinate
    y: Coordinate
    pixel: Annotated[float, Meta(gt=0, le=1e4)]
    handle: Annotated[str, Meta(max_length=40)] | None = None
    shift: bool = False
    ctrl: bool = False


class Answer(msgspec.Struct, frozen=True, tag="answer", tag_field="type"):
    """What was typed where the map asked; None: Escape."""

    question: int
    value: Annotated[str, Meta(max_length=1000)] | None = None


class Press(msgspec.Struct, frozen=True, tag="press", tag_field="type"):
    """A button of our own HTML was pressed: what it does, and to what."""

    do: Annotated[str, Meta(max_length=20)]
    arg: Annotated[str, Meta(max_length=2000)] = ""


FromBrowser = Commit | Revert | Pointer | Answer | Press


class Bridge:
    """The two-way channel of one browser."""

    def __init__(self, client: viser.ClientHandle, hear: Callable[[FromBrowser], None]) -> None:
        self._client = client
        channel = client.gui.add_text("rgviz channel", "", visible=False)

        @channel.on_update
        async def _(event: viser.GuiEvent[Any]) -> None:
            if event.client is not None and (message := read(channel.value)) is not None:
                hear(message)

        self.tell("hello", channel=channel._impl.uuid)

    def tell(self, kind: str, **values: Any) -> None:
        """Hand a message to ``rg.receive`` in the page; it waits there until the page is ready."""
        text = msgspec.json.encode({"type": kind, **values}).decode()
        source = f"(window.rgInbox = window.rgInbox || []).push({text});"
        self._client._websock_connection.queue_message(viser._messages.RunJavascriptMessage(source=source))


def read(text: str) -> FromBrowser | None:
    """A message from a browser; None for anything that is none."""
    try:
        return msgspec.json.decode(text, type=FromBrowser)
    except msgspec.DecodeError:
        return None
