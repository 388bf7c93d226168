"""What the panels say: the right numbers, and no HTML that came from outside."""

from __future__ import annotations

from html.parser import HTMLParser

import pytest
from office_map import office_map

from rgcore.model.edits import ClassifyRegion, LabelObject, RenameGateway, RenameRegion
from rgcore.model.records import Provenance, RGMap, replace
from rgviz import facts, overview, status
from rgviz.jobs import Report
from rgviz.picking import Item

MAP = office_map(4, 1, 2)
HOSTILE = '<img src=x onerror="alert(1)">'


class Words(HTMLParser):
    """The text of some HTML and the elements that it opens."""

    def __init__(self, html: str) -> None:
        super().__init__()
        self.text, self.tags = "", set[str]()
        self.feed(html)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.add(tag)
        assert not [a for a, _ in attrs if a.startswith("on")]

    def handle_data(self, data: str) -> None:
        self.text += f" {data}"


def test_region_numbers() -> None:
    text = Words(facts.item(MAP, Item("region", "r4"))).text
    for expected in ("19.0 m²", "3.30 × 4.50 m", "0°, 90°", "3.8 cm", "g3", "o2", "0.85", "the mapper"):
        assert expected in text
    unseen = replace(MAP, regions={"r4": replace(MAP.regions["r4"], accuracy=None)})
    assert "no evidence" in facts.item(unseen, Item("region", "r4"))


def test_line_gateway_and_object_numbers() -> None:
    line = Words(facts.item(MAP, Item("line", "l2"))).text
    assert "5.00 m" in line
    assert "25 segments" in line
    assert "11.0 mm" in line
    assert "Uncertainty unknown" in line
    sure = replace(MAP, lines={"l2": replace(MAP.lines["l2"], support=1, deviation=(0.0042, 0.0021))})
    told = Words(facts.item(sure, Item("line", "l2"))).text
    assert "± 4.2 mm across, ± 0.12°" in told
    assert "1 segment " in told
    gateway = Words(facts.item(MAP, Item("gateway", "g3"))).text
    assert "0.90 m" in gateway
    assert "r2" in gateway
    assert "r4" in gateway
    assert "90 %" in gateway
    box = Words(facts.item(MAP, Item("object", "o2"))).text
    assert "0.90 × 0.50 × 1.00 m" in box
    assert "4 of 4" in box
    lines = Words(facts.many(MAP, (Item("line", "l1"), Item("line", "l2")))).text
    assert "2 lines" in lines
    assert "7.00 m in all" in lines


def test_area_leaves_holes_out() -> None:
    r = MAP.regions["r4"]
    hole = ((5.0, 1.0), (5.0, 2.0), (6.0, 2.0), (6.0, 1.0))
    assert facts.area(r) == pytest.approx(19.0)
    assert facts.area(replace(r, holes=(hole,))) == pytest.approx(18.0)


def test_provenance_in_words() -> None:
    assert facts.provenance(Provenance()) == "the mapper"
    assert "edited" in facts.provenance(Provenance(source="edited", at="2026-01-01T10:00:00Z"))
    assert facts.provenance(Provenance(source="human")) == "a person"
    assert facts.provenance(Provenance(source="edited", by="Ada")) == "the mapper, edited by Ada"
    told = Words(facts.origin(Provenance(source="edited", edits=(2, 7)), {7: "rename r4 to lab"})).text
    assert "rename r4 to lab" in told
    assert "edit 2" in told
    assert "to check" in told
    assert "confirmed" in facts.origin(Provenance(confirmed=True), {})


def test_everything_foreign_is_escaped() -> None:
    m = RenameRegion(region="r4", name=HOSTILE).apply(MAP)
    m = ClassifyRegion(region="r4", class_=HOSTILE).apply(m)
    m = RenameGateway(gateway="g3", name=HOSTILE).apply(m)
    m = LabelObject(object="o2", label=HOSTILE).apply(m)
    m = replace(m, source=replace(m.source, log=HOSTILE))
    kinds = (("region", "r4"), ("gateway", "g3"), ("object", "o2"), ("line", "l2"))
    pages = [facts.item(m, Item(k, i)) for k, i in kinds]  # type: ignore[arg-type]
    pages += [overview.overview(m, HOSTILE), overview.legend(m), overview.downloads(HOSTILE, {".json": HOSTILE})]
    pages += [status.failed(HOSTILE), status.waiting(HOSTILE, status.Pace())]
    for page in pages:
        assert "img" not in Words(page).tags
    assert HOSTILE in Words(pages[0]).text


def test_legend_counts_by_class() -> None:
    text = " ".join(Words(overview.legend(MAP)).text.split())
    assert "TOMA room with two main axes 6" in text
    assert "narrow passage 8" in text
    assert "T-junction 1" in text
    assert Words(overview.legend(RGMap())).text.strip() == ""


def test_progress_tells_stage_share_and_pace(monkeypatch: pytest.MonkeyPatch) -> None:
    now = [100.0]
    monkeypatch.setattr(status.time, "monotonic", lambda: now[0])
    pace = status.Pace()
    assert "Starting" in status.progress(pace)
    pace.hear(Report("slam", 0, 1000))
    now[0] += 2.0
    pace.hear(Report("slam", 500, 1000))
    text = Words(status.progress(pace)).text
    assert "Finding the robot's way" in text
    assert "50 %" in text
    assert "250 scans/s" in text
