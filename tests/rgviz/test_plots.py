"""Plots of the inspector, and the figures that come from a run's evidence."""

from __future__ import annotations

import math
import re
import xml.etree.ElementTree as ET
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from office_map import office_map

from rgcore.lines.adaptation import Adaptation, Curve
from rgcore.model.folder import KeptSegments
from rgcore.model.records import replace
from rgcore.slam.trajectory import Trajectory
from rgviz import facts, overview, plots
from rgviz.figures import Figures

MAP = office_map(4, 1, 2)
CURVE = Curve(lines=(20, 12, 30, 25), accuracy=(0.05, 0.08, 0.04, 0.07), scans=9, chosen=0)


def test_directions_count_metres_and_know_no_forwards() -> None:
    ends = np.array([[[0, 0], [3, 0]], [[5, 1], [1, 1]], [[0, 0], [0, 2]], [[0, 0], [1, 1]]], float)
    metres = plots.directions(ends)
    assert metres[0] == pytest.approx(7)
    assert metres[plots.BINS // 2] == pytest.approx(2)
    assert metres[plots.BINS // 4] == pytest.approx(math.sqrt(2))
    assert metres.sum() == pytest.approx(9 + math.sqrt(2))


def test_plots_are_pictures_with_their_numbers() -> None:
    ends = np.array([(v.start, v.end) for v in MAP.lines.values()])
    histogram = ET.fromstring(plots.angle_histogram(ends, (0.0, math.pi / 2)))
    assert len([e for e in histogram if e.tag == "rect"]) == 2
    assert len([e for e in histogram if e.get("class") == "mark"]) == 2
    assert plots.angle_histogram(np.zeros((0, 2, 2)), ()) == ""
    trade = ET.fromstring(plots.trade_off(CURVE))
    dots = [e for e in trade if e.tag == "circle"]
    assert [e.get("class") for e in dots].count("chosen") == 1
    assert [t.text for e in dots for t in e][-1] == "20 lines, 5.0 cm"
    front = next(e for e in trade if e.tag == "polyline").get("points", "")
    assert len(front.split()) == 3, "the setting that another beats in both is not on the front"
    assert plots.trade_off(Curve(lines=(3,), accuracy=(0.1,), scans=1, chosen=0)) == ""
    for picture in (histogram, trade):
        for e in picture.iter():
            for value in (e.get("x"), e.get("cx")):
                assert value is None or 0 <= float(value) <= plots.WIDTH


def figures() -> Figures:
    """Of a run with two scans in r4 that see its walls 2 cm farther than the map has them, and one in the hall."""
    poses = np.array([[5.9, 2.5, 0.0], [5.8, 2.5, 0.0], [6.0, 6.0, 0.0]])
    bearings = np.radians(np.arange(-180.0, 180.0, 2.0))
    from rgcore.lines.accuracy import predict

    ends = np.array([(v.start, v.end) for v in MAP.lines.values()])
    ranges = predict(ends, poses, bearings, 12.0)
    ranges = np.where(np.isfinite(ranges), ranges + 0.02, 0.0)
    kept = KeptSegments(
        ends=np.array([[[4.0, 0.1], [4.0, 4.9]], [[4.02, 1.0], [4.02, 3.0]], [[9.0, 0.0], [9.0, 5.0]]]),
        scan=np.array([0, 1, 2]), readings=np.ones(3, int), deflated=1,
        sample=np.arange(3), ranges=ranges, bearings=bearings,
    )  # fmt: skip
    fitted = Adaptation(tried=({}, {}, {}, {}), map=CURVE, regions=(CURVE,) * 11, price=1.0)
    project: Any = SimpleNamespace(
        map=MAP, base=MAP, segments=kept, adaptation=fitted, run_info=SimpleNamespace(config={}),
        trajectory=Trajectory(np.arange(3.0), poses, np.zeros(3)),
    )  # fmt: skip
    return Figures(project)


def test_robust_figures_are_those_of_the_scans_in_the_region() -> None:
    f = figures()
    fit = f.fit(MAP.regions["r4"])
    assert fit is not None
    assert fit.median == pytest.approx(0.02, abs=1e-3)
    assert fit.within_10 > 0.9
    assert f.fit(MAP.regions["r9"]) is None, "no scan was taken there"
    wall = next(v for v in MAP.lines.values() if v.start[0] == v.end[0] == 4.0 and v.regions == ("r4",))
    assert f.scans_of(wall) == 2
    assert f.curve("r4") == CURVE
    assert f.curve("ru00000000") is None, "a region of a person has no curve"


def test_the_inspector_shows_them() -> None:
    f = figures()
    told = facts.region(MAP, "r4", f)[0]
    assert "2.0 cm" in told
    assert "Not predicted" in told
    assert facts.region_plots(MAP, MAP.regions["r4"], f).count("<svg") == 2
    assert facts.region_plots(MAP, replace(MAP.regions["r4"], id="ru1"), None) == ""
    assert overview.overview(MAP, "office", f).count("<svg") == 1
    assert "<svg" not in overview.overview(MAP, "office")


def test_plots_take_their_colours_from_the_page() -> None:
    css = (Path(__file__).parents[2] / "static" / "rgviz.css").read_text()
    used = set(
        re.findall(r'class="([\w-]+)"', plots.trade_off(CURVE) + plots.angle_histogram(np.ones((1, 2, 2)), (0.0,)))
    )
    for name in used - {"plot"}:
        assert f"svg.plot .{name} " in css, name
