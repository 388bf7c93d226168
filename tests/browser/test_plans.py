"""A floor plan under the map, as a person brings it, aligns it and looks at it."""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from pilot import Pilot

from rgcore.errors import InputError
from rgcore.model.backdrops import placed
from rgviz.app import App, view
from rgviz.server import LARGEST_FILE

sys.path.append(str(Path(__file__).parents[1] / "scans"))

from make_plans import WALLS, drawing, image

Open = Callable[..., Pilot]
MIDDLE = np.ptp(WALLS, axis=0) / 2


def bring(p: Pilot, file: Path | tuple[str, bytes]) -> None:
    """Choose a file in the dialogue of the page: one that is there, or one of any name."""
    with p.page.expect_file_chooser() as chooser:
        p.button("Lay a plan under the map").click()
    if isinstance(file, Path):
        chooser.value.set_files(file)
    else:
        chooser.value.set_files({"name": file[0], "mimeType": "application/octet-stream", "buffer": file[1]})


def corner(app: App, n: int) -> np.ndarray:
    """Where a corner of the walls on the plan lies on the map now."""
    plan = next(iter(app.map.backdrops.values()))
    unit = 20.0 if plan.form != "dxf" else 1.0  # pixels a metre
    return placed(plan, (np.array(WALLS[n]) - MIDDLE) * unit)


def color(p: Pilot, at: np.ndarray) -> np.ndarray:
    """RGB of the picture at a place of the map."""
    (x, y), (left, top, _, _) = p.at(*at), p.canvas_box()
    return p.picture()[int(y - top), int(x - left)].astype(int)


def dark(p: Pilot, a: np.ndarray, b: np.ndarray, below: int = 150) -> float:
    """Share of the way between two places of the map on which the picture is dark.

    Of 255; floors have 170 and more, a thin line between two rows of pixels is half as dark as ink.
    """
    picture, (left, top, _, _) = p.picture(), p.canvas_box()
    hits = []
    for t in np.linspace(0.1, 0.9, 30):
        x, y = p.at(*(a + t * (b - a)))
        spot = picture[int(y - top) - 2 : int(y - top) + 3, int(x - left) - 2 : int(x - left) + 3]
        hits.append(spot.min(2).min() < below)
    return float(np.mean(hits))


@pytest.mark.parametrize(("name", "data"), [("plan.png", image()), ("plan.dxf", drawing())])
def test_a_plan_is_brought_aligned_by_two_points_and_undone(app: App, open_page: Open, name: str, data: bytes) -> None:
    p = open_page(app.url, size=(1180, 900))
    bring(p, (name, data))
    p.see(name)
    p.until(lambda: bool(app.map.backdrops))
    (id,) = app.map.backdrops
    p.wait_nodes(f"/backdrop/{id}")
    p.see(f"Undo: lay {name} under the map")
    for layer in ("Lines", "Points", "Gateways", "Objects", "Outlines"):
        p.layer(layer).uncheck()
    p.page.wait_for_timeout(300)
    p.shot(f"{name}-laid")
    assert dark(p, corner(app, 0), corner(app, 1)) > 0.9  # what is drawn lies where the map says, the right way up
    assert dark(p, corner(app, 2), corner(app, 3)) > 0.9
    assert dark(p, *((corner(app, n) + 0.6) for n in (0, 1))) < 0.3

    here = [corner(app, 0), corner(app, 2)]
    there = [np.array([2.0, 1.0]), np.array([-1.0, 9.0])]  # turned to the left by a quarter, same length
    p.button("Align by points").click()
    p.see("Click a point of the plan")
    for a, b in zip(here, there, strict=True):
        p.click(*a)
        p.page.wait_for_timeout(150)
        p.click(*b)
        p.page.wait_for_timeout(150)
    p.see(f"Undo: align {name}")
    np.testing.assert_allclose([corner(app, 0), corner(app, 2)], there, atol=0.1)
    p.page.wait_for_timeout(300)
    p.shot(f"{name}-aligned")
    assert dark(p, corner(app, 0), corner(app, 1)) > 0.9
    p.key("Control+z")
    p.see(f"Undo: lay {name} under the map")
    np.testing.assert_allclose(corner(app, 0), here[0], atol=1e-5)

    p.type_into("Plan turn (°)", "90")
    p.see(f"Undo: align {name}")
    assert app.map.backdrops[id].yaw == pytest.approx(np.pi / 2)
    p.layer("Floor plan").uncheck()
    p.until(lambda: not p.visible(f"/backdrop/{id}"))
    p.layer("Floor plan").check()
    paper = (corner(app, 0) + corner(app, 2)) / 2  # within the walls, where nothing is drawn
    p.page.wait_for_timeout(300)
    bare = color(p, paper)
    p.layer("Floor plan opacity").fill("20")
    p.page.wait_for_timeout(300)
    p.shot(f"{name}-faint")
    assert dark(p, corner(app, 0), corner(app, 1), below=110) < 0.3
    assert np.abs(color(p, paper) - bare).max() <= 3
    p.button("Take away").click()
    p.gone("Take away")
    assert not app.map.backdrops
    p.key("Control+z")
    p.wait_nodes(f"/backdrop/{id}")


def test_what_is_no_plan_is_refused_and_nothing_is_kept(app: App, open_page: Open, tmp_path: Path) -> None:
    p = open_page(app.url, size=(1180, 900))
    bring(p, ("../../../etc/hosts.png", b"127.0.0.1 localhost"))
    p.see("hosts.png: no floor plan; expected png, jpg or DXF")
    (tmp_path / "huge.png").write_bytes(bytes(LARGEST_FILE + 1))
    bring(p, tmp_path / "huge.png")
    p.see("larger than 32 MB")
    bring(p, ("../../plan.png", image()))
    p.see("Undo: lay plan.png under the map")
    project = app.opened.project.path
    assert [f.name for f in (project / "backdrops").iterdir()] == [p_.sha256 for p_ in app.map.backdrops.values()]


def test_who_came_to_look_sees_the_plan_and_cannot_bring_one(app: App, open_page: Open) -> None:
    edit = app.opened.project.add_backdrop(image(), "plan.png")
    app.backdrops.show(app.map)
    p = open_page(app.view_url, ("/lines/lines", f"/backdrop/{edit.id}"))
    p.see("plan.png")
    assert p.button("Lay a plan under the map").count() == 0
    assert p.button("Align by points").count() == 0


def test_the_command_line_lays_a_plan_once(app: App, open_page: Open, tmp_path: Path) -> None:
    (tmp_path / "plan.png").write_bytes(image())
    app.backdrop = tmp_path / "plan.png"
    project = app.opened.project.path
    for _ in range(2):
        app.opened.project.close()
        app.open_project(project)
    p = open_page(app.url)
    p.see("plan.png")
    assert len(app.map.backdrops) == 1
    with pytest.raises(InputError, match="cannot be read"):
        view(project, backdrop=tmp_path / "none.png")
