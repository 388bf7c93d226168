"""The formats that a map is written to, by the ending of the file.

To add one, write a module with ``render(map, trajectory, options) -> bytes`` and add a row to ``FORMATS``.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

from rgcore.errors import RgError
from rgcore.exports import gltf, rgjson, svg, tum
from rgcore.exports.options import Options
from rgcore.model.disk import replace_file
from rgcore.model.records import RGMap
from rgcore.slam.trajectory import Trajectory

Render = Callable[[RGMap, "Trajectory | None", Options], bytes]


class Format(NamedTuple):
    """``title`` for menus, ``media_type`` for downloads, ``render`` gives the bytes of the file."""

    title: str
    media_type: str
    render: Render


FORMATS: dict[str, Format] = {
    ".json": Format("Map (JSON)", "application/json", rgjson.render),
    ".glb": Format("3D model (glTF)", "model/gltf-binary", gltf.render),
    ".svg": Format("Drawing (SVG)", "image/svg+xml", svg.render),
    ".tum": Format("Trajectory (TUM)", "text/plain", tum.render),
}
"""By ending, in the order in which menus show them."""


def render(ending: str, map: RGMap, trajectory: Trajectory | None = None, *, wall_height: float = 2.5) -> bytes:
    """The map in the format of an ending such as ``.glb``.

    wall_height: m, how high lines are extruded where the format has a height. Raises RgError for an unknown ending, a
    setting out of bounds, or where the format needs a trajectory and there is none.
    """
    found = FORMATS.get(ending.lower())
    if found is None:
        raise RgError(f"no export format {ending or '(no ending)'}; known endings: {' '.join(FORMATS)}")
    if not 0.01 <= wall_height <= 100:
        raise RgError(f"wall height {wall_height:g} m: must lie between 0.01 and 100 m")
    return found.render(map, trajectory, Options(wall_height=wall_height))


def export(path: str | Path, map: RGMap, trajectory: Trajectory | None = None, *, wall_height: float = 2.5) -> None:
    """Write the map to a file; its ending names the format. The file is there whole or not at all.

    Raises RgError as :func:`render` does, and where the file cannot be written.
    """
    path = Path(path)
    try:
        data = render(path.suffix, map, trajectory, wall_height=wall_height)
    except RgError as e:
        raise RgError(f"{path}: {e}") from e
    try:
        replace_file(path, data)
    except OSError as e:
        raise RgError(f"{path}: cannot be written: {e.strerror or e}") from e
