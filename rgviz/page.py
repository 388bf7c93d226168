"""What all browsers get from viser's page: title bar, docked panel, first camera, keys; and where their events go."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import viser
from viser.theme import TitlebarConfig

from rgviz import theme
from rgviz.commands import COMMANDS, HELP_KEY, Command, split_key

if TYPE_CHECKING:
    from rgviz.app import App


def furnish(app: App) -> None:
    """Set up the server of an app. Callbacks are coroutines, which viser runs in order, and do nothing but post."""
    _look(app.server)
    for command in COMMANDS:
        for key in command.keys or (None,):
            _register(app, command, None if key == HELP_KEY else key)

    @app.server.scene.on_click()  # type: ignore[arg-type]
    async def _(event: Any) -> None:
        app.ask(event.client_id, lambda view: view.click(event))

    for modifier in ("shift", "cmd/ctrl"):
        _let_choose(app, modifier)

    @app.server.on_client_connect
    async def _(client: viser.ClientHandle) -> None:
        app.worker.post(app.join, client)

    @app.server.on_client_disconnect
    async def _(client: viser.ClientHandle) -> None:
        app.worker.post(app.leave, client)


def dress(gui: viser.GuiApi, dark: bool = False) -> None:
    """Title bar and colours of viser's own widgets, for all browsers or one."""
    titlebar: TitlebarConfig = {
        "image": {
            "image_url_light": "/static/logo.svg",
            "image_url_dark": "/static/logo-dark.svg",
            "image_alt": theme.NAME,
            "href": None,
        },
        "buttons": ({"text": "Help", "icon": "Description", "href": "/help"},),
    }
    gui.configure_theme(
        titlebar_content=titlebar,
        dark_mode=dark,
        show_logo=False,
        show_share_button=False,
        brand_color=theme.PAGE_BRAND,
    )


def _look(server: viser.ViserServer) -> None:
    dress(server.gui)
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


def _let_choose(app: App, modifier: str) -> None:
    """Clicks and rectangles with a key held: Shift adds, Ctrl takes away."""
    scene: Any = app.server.scene

    @scene.on_click(modifier=modifier)
    async def _(event: Any) -> None:
        app.ask(event.client_id, lambda view: view.click(event, add=True))

    @scene.on_rect_select(modifier=modifier)
    async def _(event: Any) -> None:
        app.ask(
            event.client_id, lambda view: view.select_within(event.screen_min, event.screen_max, modifier == "shift")
        )
