"""Every command once: the table feeds the keys, the command palette, the buttons of the panel and the help text."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

from rgcore.model.edits import Edit
from rgcore.model.records import GATEWAY_CLASSES, REGION_CLASSES, RGMap
from rgviz import actions, selecting
from rgviz.picking import Kind
from rgviz.selecting import Items
from rgviz.theme import CLASS_TITLES
from rgviz.tools.drawing import GatewayTool, RegionTool, WallTool
from rgviz.tools.measuring import Ruler
from rgviz.tools.pointing import CutLineTool, SelectTool

if TYPE_CHECKING:
    from rgviz.view import View


@dataclass(frozen=True)
class Command:
    """``keys``: "Z", "cmd/ctrl+Z" ... as viser names them, the first one shown; ``run`` acts for who asked.

    group  under which heading it stands
    kinds  what it works on when that is selected; none: always
    least  how many of them it takes
    """

    name: str
    title: str
    run: Callable[[View], None]
    keys: tuple[str, ...] = ()
    group: str = "Map"
    kinds: tuple[Kind, ...] = ()
    least: int = 1


HELP_KEY = "?"
"""viser takes letters and digits alone; ``static/seeing.js`` listens for this one"""


def _act(action: Callable[[RGMap, Items], Edit]) -> Callable[[View], None]:
    def run(view: View) -> None:
        view.act(action)

    return run


ANY: tuple[Kind, ...] = ("region", "gateway", "line", "object", "note")
CHECKED: tuple[Kind, ...] = ("region", "gateway", "line", "object")


def _digit(n: int) -> Command:
    region = f"{REGION_CLASSES[n - 1]} ({CLASS_TITLES[REGION_CLASSES[n - 1]]})" if n <= len(REGION_CLASSES) else ""
    names = " or ".join(filter(None, (region, CLASS_TITLES[GATEWAY_CLASSES[n - 1]])))
    return Command(
        f"class-{n}",
        f"Relabel as {names}",
        _act(lambda _, items: actions.relabel_by_digit(items, n)),
        (str(n),),
        "Regions and gateways",
        ("region", "gateway") if region else ("gateway",),
    )


COMMANDS: tuple[Command, ...] = (
    Command("undo", "Undo", lambda v: v.undo(), ("cmd/ctrl+Z",)),
    Command("redo", "Redo", lambda v: v.redo(), ("cmd/ctrl+shift+Z", "cmd/ctrl+Y")),
    Command("fit", "Show the whole map", lambda v: v.fit(), ("F",)),
    Command("zoom", "Zoom to the selection", lambda v: v.fit_selection(), ("Z",), kinds=ANY),
    Command("turn", "2D / 3D", lambda v: v.turn(), ("V",)),
    Command("top", "Straight down, the whole map", lambda v: v.look_down(), ("shift+V",)),
    Command("find", "Lists and search", lambda v: v.panels.search(), ("shift+F",)),
    Command("review", "Work list and what looks wrong", lambda v: v.panels.open_tab("Review"), ("shift+T",)),
    Command("history", "History of edits", lambda v: v.panels.open_tab("History"), ("shift+H",)),
    Command("again", "Map again, and what became of the edits", lambda v: v.panels.open_tab("Runs"), ("shift+N",)),
    Command("turn-run", "Look at the new run, or at the map", lambda v: v.looking.turn(), ("shift+J",)),
    Command("changes", "What is different from the run before", lambda v: v.looking.switch_changes(), ("shift+K",)),
    Command("measure", "Measure", lambda v: v.take(Ruler()), ("shift+M",)),
    Command("dark", "Light / dark", lambda v: v.switch_look()),
    Command("help", "All keys and commands", lambda v: v.show_keys(), (HELP_KEY,)),
    # ---- what is selected
    Command("clear", "Put the tool away, select nothing", lambda v: v.escape(), ("escape",), "Selection"),
    Command("finish", "Finish what is drawn", lambda v: v.hands.finish(), ("enter",), "Selection"),
    Command("delete", "Delete the selection", lambda v: v.delete(), ("delete", "backspace"), "Selection", ANY),
    Command("rename", "Rename", lambda v: v.edit_name(), ("N",), "Selection", ("region", "gateway", "object")),
    Command("select", "Select by rectangle", lambda v: v.take(SelectTool(items=v.selection)), ("R",), "Selection"),
    Command(
        "lines", "Select all lines of the region", lambda v: v.select(selecting.lines_of(v.map, v.selection)),
        ("shift+L",), "Selection", CHECKED,
    ),
    Command(
        "invert", "Invert the selection", lambda v: v.select(selecting.others(v.map, v.selection)),
        ("shift+I",), "Selection",
    ),
    # ---- review
    Command("next", "Next to check", lambda v: v.review.next(), ("U",), "Review"),
    Command("previous", "Previous to check", lambda v: v.review.next(-1), ("shift+U",), "Review"),
    Command("confirm", "Confirm, go on to the next", lambda v: v.review.confirm(), ("C",), "Review", CHECKED),
    Command(
        "reject", "Not there: delete, go on to the next", lambda v: v.review.reject(),
        ("shift+delete", "shift+backspace"), "Review", CHECKED,
    ),
    Command("unconfirm", "Check again", _act(lambda _, i: actions.unconfirm(i)), ("shift+C",), "Review", CHECKED),
    Command("revert", "Revert to automatic", _act(actions.revert), ("shift+R",), "Review", CHECKED),
    Command("note", "Write a note", lambda v: v.write_note(), ("T",), "Review"),
    # ---- regions and gateways
    *(_digit(n) for n in range(1, len(GATEWAY_CLASSES) + 1)),
    Command("split", "Split a region by a line", lambda v: v.split(), ("X",), "Regions and gateways"),
    Command(
        "split-gateway", "Split a region by a gateway", lambda v: v.split(gateway=True), ("shift+X",),
        "Regions and gateways",
    ),
    Command("merge", "Merge regions", lambda v: v.merge(), ("M",), "Regions and gateways", ("region",), 2),
    Command("reshape", "Reshape the outline", lambda v: v.reshape(), ("O",), "Regions and gateways", ("region",)),
    Command("region", "Add a region", lambda v: v.take(RegionTool()), ("P",), "Regions and gateways"),
    Command("gateway", "Add a gateway", lambda v: v.take(GatewayTool()), ("G",), "Regions and gateways"),
    Command(
        "assign", "Join or bound other regions", lambda v: v.assign(), ("shift+G",), "Regions and gateways",
        ("gateway", "line"),
    ),
    # ---- lines
    Command("wall", "Draw a wall", lambda v: v.take(WallTool()), ("L",), "Lines"),
    Command("join", "Join collinear lines", _act(lambda _, items: actions.join(items)), ("J",), "Lines", ("line",), 2),
    Command("cut", "Split a line", lambda v: v.take(CutLineTool()), ("K",), "Lines"),
    Command("align", "Align to the main axis", _act(actions.align), ("I",), "Lines", ("line",)),
    Command("clutter", "Clutter, or wall again", _act(actions.clutter), ("H",), "Lines", ("line",)),
    # ---- objects
    Command("box", "Make an object of the selected lines", lambda v: v.make_object(), ("B",), "Objects", ("line",)),
    Command(
        "rectangle", "Make an object by rectangle", lambda v: v.draw_box(),
        ("shift+B",), "Objects",
    ),
)  # fmt: skip
BY_NAME = {c.name: c for c in COMMANDS}


def fitting(items: Items) -> list[Command]:
    """The commands that work on a selection, in the order of the table."""
    return [c for c in COMMANDS if items and items[0].kind in c.kinds and len(items) >= c.least]


def split_key(key: str) -> tuple[str, str | None]:
    """``cmd/ctrl+shift+Z`` as ("Z", "cmd/ctrl+shift")."""
    modifier, _, letter = key.rpartition("+")
    return letter, modifier or None


def spoken(key: str) -> str:
    """A key as people write it: ``Ctrl+Shift+Z``."""
    words = {"cmd/ctrl": "Ctrl", "escape": "Esc", "delete": "Del"}
    return "+".join(words.get(part, part.capitalize()) for part in key.split("+"))
