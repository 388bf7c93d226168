"""The directory listing is the way of the data: a module imports only from its own room or from earlier ones."""

from __future__ import annotations

import ast
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
ORDER = ("geometry", "scans", "slam", "lines", "places", "model", "robot", "exports")
GROUND = {"errors", "config", "evidence", "progress"}
TOP = {"pipeline", "cache", "online"}  # stand beside the rooms: they see all of them, no room sees them
HEAVY = {  # heavy library -> the files that may import it
    "viser": ("rgviz/",),
    "websockets": ("rgviz/",),
    "rich": ("rgviz/",),
    "trimesh": ("rgcore/exports/gltf.py",),
    "shapely": ("rgcore/geometry/polygons.py", "rgcore/geometry/cutting.py"),
    "cv2": (
        "rgcore/geometry/grid.py",
        "rgcore/scans/backdrop.py",
        "rgcore/scans/plan_image.py",
        "rgcore/scans/grid_map.py",
        "rgcore/exports/nav2.py",
    ),
    "sklearn": ("rgcore/places/train",),
}
MODULES = sorted(p for top in ("rgcore", "rgviz") for p in (ROOT / top).rglob("*.py"))


def imports(path: Path) -> set[str]:
    """Dotted names that a file imports at run time; ``from a import b`` gives a.b as well, since b may be a module."""
    tree = ast.parse(path.read_text(encoding="utf-8"))
    typing_only = {
        n
        for block in ast.walk(tree)
        if isinstance(block, ast.If) and "TYPE_CHECKING" in ast.dump(block.test)
        for n in ast.walk(block)
    }
    names: set[str] = set()
    for node in ast.walk(tree):
        if node in typing_only:
            continue
        if isinstance(node, ast.Import):
            names |= {a.name for a in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module:
            names |= {node.module} | {f"{node.module}.{a.name}" for a in node.names}
    return names


@pytest.mark.parametrize("path", MODULES, ids=lambda p: str(p.relative_to(ROOT)))
def test_a_module_imports_only_from_earlier_rooms(path: Path) -> None:
    where = path.relative_to(ROOT).parts
    for name in imports(path):
        parts = name.split(".")
        if where[0] == "rgcore":
            assert parts[0] != "rgviz", f"{name}: nothing in rgcore knows that there is an app"
        if parts[0] != "rgcore" or len(parts) < 2 or where[0] != "rgcore" or len(where) < 3:
            continue
        assert parts[1] not in TOP, f"{name}: a room does not know the pipeline"
        if parts[1] in GROUND or parts[1] not in ORDER:
            continue
        assert ORDER.index(parts[1]) <= ORDER.index(where[1]), (
            f"{name} comes later in the way of the data than {where[1]}"
        )


@pytest.mark.parametrize("path", MODULES, ids=lambda p: str(p.relative_to(ROOT)))
def test_heavy_libraries_stay_in_their_place(path: Path) -> None:
    relative = path.relative_to(ROOT).as_posix()
    for name in imports(path):
        allowed = HEAVY.get(name.split(".")[0])
        assert allowed is None or relative.startswith(allowed), f"{name} is imported outside {allowed}"


def test_the_library_works_without_viser() -> None:
    code = (
        "import sys\n"
        "class Absent:\n"
        "    def find_spec(self, name, path=None, target=None):\n"
        "        if name.split('.')[0] in ('viser', 'websockets', 'rich'):\n"
        "            raise ImportError(name + ' is not installed')\n"
        "sys.meta_path.insert(0, Absent())\n"
        "import rgcore.pipeline, rgcore.model.project, rgcore.exports.formats\n"
    )
    subprocess.run([sys.executable, "-c", code], check=True, cwd=ROOT)
