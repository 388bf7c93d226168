"""What all browsers get from viser's page: title bar, docked panel, first camera, keys; and where their events go."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import viser
from viser.theme import TitlebarConfig

from rgviz import theme
from rgviz.commands import COMMANDS, Command, split_key

if TYPE_CHECKING:
    from rgviz.app import App


def furnish(app: App) -> None:
    """Set up the server of an app. Callbacks are coroutines, which viser runs in order, and do nothing but post."""
    _look(app.server)
    for command in COMMANDS:
        for key in command.keys or (None,):
            _register(app, command, key)

    @app.server.scene.on_click()  # type: ignore[arg-type]
    async def _(event: Any) -> None:
        app.ask(event.client_id, lambda view: view.click(event))

    @app.server.scene.on_click(modifier="shift")  # type: ignore[arg-type]
    async def _(event: Any) -> None:
        app.ask(event.client_id, lambda view: view.click(event, add=True))

    @app.server.on_client_connect
    async def _(client: viser.ClientHandle) -> None:
        app.worker.post(app.join, client)

    @app.server.on_client_disconnect
    async def _(client: viser.ClientHandle) -> None:
        app.worker.post(app.leave, client)


def _look(server: viser.ViserServer) -> None:
    titlebar: TitlebarConfig = {
        "image": {"image_url_light": "/static/logo.svg", "image_url_dark": None, "image_alt": theme.NAME, "href": None},
        "buttons": ({"text": "Help", "icon": "Description", "href": "/static/help.html"},),
    }
    server.gui.configure_theme(
        titlebar_content=titlebar,
        show_logo=False,
        show_share_button=False,
        brand_color=theme.PAGE_BRAND,
    )
    server.gui.set_panel_label("Edit")
    server.gui.main_panel.dock_right()
    server.gui.main_panel.set_width(330)
    camera = server.initial_camera  # until static/rgviz.js fits the map to the window
    camera.position, camera.look_at, camera.up = (0.0, -0.01, 200.0), (0.0, 0.0, 0.0), (0.0, 0.0, 1.0)
    camera.fov, camera.near, camera.far = 0.1, 10.0, 1000.0


def _register(app: App, command: Command, key: str | None) -> None:
    letter, modifier = split_key(key) if key else (None, None)
    entry = app.server.gui.add_command(command.title, hotkey=letter, modifier=modifier)  # type: ignore[arg-type]

    @entry.on_trigger
    async def _(event: Any) -> None:
        app.ask(event.client_id, command.run)
