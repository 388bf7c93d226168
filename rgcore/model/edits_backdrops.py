"""Edits of the floor plans that lie under a map, and how one is laid there by points that belong together."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from rgcore.errors import EditError
from rgcore.model.edit import Edit, drop, must_be_new, put, the_backdrop
from rgcore.model.fields import Angle, BackdropId, Name, NewBackdropId, Place, PlanForm, PlanLength, PlanSize, Sha256
from rgcore.model.records import Backdrop, Point, RGMap, replace, rounded

APART = 0.05
"""m: two points nearer than this turn a plan by chance"""


class AddBackdrop(Edit, frozen=True):
    """A floor plan lies under the map; its file is in the project already (``Project.add_backdrop``)."""

    id: NewBackdropId
    name: Name
    sha256: Sha256
    form: PlanForm
    size: PlanSize
    center: Place
    yaw: Angle
    length: PlanLength

    def change(self, map: RGMap) -> RGMap:
        must_be_new(map, "backdrops", self.id)
        names = ("id", "name", "sha256", "form", "size", "center", "yaw", "length")
        return put(map, "backdrops", Backdrop(**{n: getattr(self, n) for n in names}))

    def title(self, map: RGMap) -> str:
        return f"lay {self.name} under the map"


class AlignBackdrop(Edit, frozen=True):
    """A floor plan lies here: its middle, its turn, and how long its longer side is there."""

    backdrop: BackdropId
    center: Place
    yaw: Angle
    length: PlanLength

    def change(self, map: RGMap) -> RGMap:
        plan = the_backdrop(map, self.backdrop)
        return put(map, "backdrops", replace(plan, center=self.center, yaw=self.yaw, length=self.length))

    def title(self, map: RGMap) -> str:
        return f"align {the_backdrop(map, self.backdrop).name}"


class DeleteBackdrop(Edit, frozen=True):
    """A floor plan lies under the map no more; its file stays in the project, for undo."""

    backdrop: BackdropId

    def change(self, map: RGMap) -> RGMap:
        return drop(map, "backdrops", the_backdrop(map, self.backdrop).id)

    def title(self, map: RGMap) -> str:
        return f"take {the_backdrop(map, self.backdrop).name} away"


def aligned(map: RGMap, backdrop: str, pairs: Sequence[tuple[Point, Point]]) -> AlignBackdrop:
    """The edit that brings points of a plan, as they lie on the map now, to where they belong: ``pairs`` of both [m].

    One pair shifts it, two turn and scale it as well (a similarity is known by two points). Raises EditError.
    """
    plan = the_backdrop(map, backdrop)
    here, there = (np.array([complex(*pair[k]) for pair in pairs]) for k in (0, 1))
    if len(pairs) not in (1, 2):
        raise EditError("a plan is aligned by one or two pairs of points")
    by = complex(1.0)
    if len(pairs) == 2:
        if min(abs(here[1] - here[0]), abs(there[1] - there[0])) < APART:
            raise EditError("the two points are one; take points that lie far apart")
        by = complex((there[1] - there[0]) / (here[1] - here[0]))
    middle = complex(there[0] + by * (complex(*plan.center) - here[0]))
    turn = float(np.angle(np.exp(1j * plan.yaw) * by))
    center = (rounded(middle.real), rounded(middle.imag))
    return AlignBackdrop(backdrop=backdrop, center=center, yaw=turn, length=plan.length * abs(by)).checked()
