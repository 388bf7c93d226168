"""What is done to a selection by one key: functions from the map and the selected items to one edit, one undo step."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from rgcore.errors import EditError
from rgcore.model import draft
from rgcore.model import edits as e
from rgcore.model.edit import several
from rgcore.model.edits import Edit
from rgcore.model.records import GATEWAY_CLASSES, REGION_CLASSES, RGMap
from rgviz.picking import Item
from rgviz.selecting import Items, ids_of, record

MOST = 1000
"""lines that one edit may name"""


def as_one(name: str, edits: Sequence[Edit]) -> Edit:
    """Several edits as one undo step of this name; a single one as it is. Raises EditError if there is none."""
    if not edits:
        raise EditError("there is nothing to do")
    return edits[0] if len(edits) == 1 else e.Several(name=name[:80], edits=tuple(edits))  # type: ignore[arg-type]


def relabel(items: Items, class_: str) -> Edit:
    """Regions or gateways get a class. Raises EditError for other things."""
    class_ = " ".join(class_.split())
    return as_one(f"relabel {count(items)} as {class_}", [_classify(i, class_) for i in items])


def relabel_by_digit(items: Items, digit: int) -> Edit:
    """Regions or gateways get the class of that number, counted from 1. Raises EditError if there is none."""
    kind = items[0].kind
    classes = GATEWAY_CLASSES if kind == "gateway" else REGION_CLASSES
    if not 1 <= digit <= len(classes):
        raise EditError(f"{kind}s have {len(classes)} classes; there is no number {digit}")
    return relabel(items, classes[digit - 1])


def _classify(item: Item, class_: str) -> Edit:
    if item.kind == "region":
        return e.ClassifyRegion(region=item.id, class_=class_)
    if item.kind == "gateway":
        return e.ClassifyGateway(gateway=item.id, class_=class_)
    raise EditError("only regions and gateways have a class; select one first")


def rename(item: Item, name: str) -> Edit:
    """A region, gateway or object gets a name, a note its text. Raises EditError for lines."""
    name = " ".join(name.split())
    if item.kind == "region":
        return e.RenameRegion(region=item.id, name=name)
    if item.kind == "gateway":
        return e.RenameGateway(gateway=item.id, name=name)
    if item.kind == "object":
        return e.LabelObject(object=item.id, label=name)
    if item.kind == "note":
        return e.WriteNote(note=item.id, text=name)
    raise EditError("a line has no name")


def delete(map_: RGMap, items: Items) -> Edit:
    """Anything goes; the mapper's own guess at an object is rejected rather than deleted."""
    one_by_one: dict[str, Callable[[str], Edit]] = {
        "region": lambda id: e.DeleteRegion(region=id),
        "gateway": lambda id: e.DeleteGateway(gateway=id),
        "note": lambda id: e.DeleteNote(note=id),
        "object": lambda id: (
            e.RejectObject(object=id) if map_.objects[id].provenance.source == "auto" else e.DeleteObject(object=id)
        ),
    }
    lines = ids_of(items, "line")
    edits: list[Edit] = [e.DeleteLines(lines=lines[n : n + MOST]) for n in range(0, len(lines), MOST)]
    return as_one(f"delete {count(items)}", edits + [one_by_one[i.kind](i.id) for i in items if i.kind != "line"])


def merge(items: Items) -> Edit:
    """Regions become the one that was selected first."""
    return e.MergeRegions(regions=_only(items, "region", 2, "Select two regions or more that lie side by side."))


def join(items: Items) -> Edit:
    """Pieces of a wall become the line that was selected first."""
    return e.JoinLines(lines=_only(items, "line", 2, "Select two lines or more of one wall."))


def align(map_: RGMap, items: Items) -> Edit:
    """Lines are laid along or across the nearest main axis of their region."""
    return draft.align_lines(map_, _only(items, "line", 1, "Select lines first."))


def clutter(map_: RGMap, items: Items) -> Edit:
    """Lines are things and no walls; walls again if all of them are things already."""
    lines = _only(items, "line", 1, "Select lines first.")
    return e.MarkClutter(lines=lines, clutter=not all(map_.lines[id].clutter for id in lines))


def box(map_: RGMap, items: Items, height: float) -> Edit:
    """A box over the selected lines."""
    lines = _only(items, "line", 1, "Select the lines of the object first: click one, Shift+click the others.")
    return draft.object_from_lines(map_, lines, height)


def confirm(items: Items) -> Edit:
    """Items were looked at and are right; an object is there for sure."""
    rest = tuple(i.id for i in items if i.kind not in ("object", "note"))
    edits: list[Edit] = [e.ConfirmObject(object=id) for id in ids_of(items, "object")]
    if not edits and not rest:
        raise EditError("a note is not confirmed; delete it when it is settled")
    return as_one(f"confirm {count(items)}", [*([e.Confirm(items=rest)] if rest else []), *edits])


def unconfirm(items: Items) -> Edit:
    """Items are to be checked again."""
    return e.Unconfirm(items=tuple(i.id for i in items))


def revert(map_: RGMap, items: Items) -> Edit:
    """Items are as the mapper made them; those of a selection of many that a person made stay."""
    touched = [i for i in items if getattr(record(map_, i), "provenance").source == "edited"]  # noqa: B009
    chosen = touched if len(items) > 1 else list(items)
    if not chosen:
        raise EditError("all of these are as the mapper made them, or made by a person")
    return as_one(f"revert {count(tuple(chosen))} to automatic", [e.RevertToAutomatic(item=i.id) for i in chosen])


def restore(ids: Sequence[str]) -> Edit:
    """Things of the automatic map that were taken away stand again as the mapper made them."""
    return as_one(f"bring back {several(ids, 'items')}", [e.RevertToAutomatic(item=id) for id in ids])


def count(items: Items) -> str:
    """The items in words: "r3", "4 lines"."""
    return items[0].id if len(items) == 1 else f"{len(items)} {items[0].kind}s"


def _only(items: Items, kind: str, least: int, otherwise: str) -> tuple[str, ...]:
    ids = ids_of(items, kind)
    if len(ids) < least:
        raise EditError(otherwise)
    return ids
