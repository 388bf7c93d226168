"""Histograms, axes and classes."""

from __future__ import annotations

import numpy as np
import pytest
from building import Building
from hypothesis import given
from hypothesis import strategies as st

from rgcore.config import Classes as Settings
from rgcore.places.classify import CLASSES, angle_histogram, classify, main_axes, network, resample
from rgcore.places.network import Network
from rgcore.places.train_classes import sample, samples_of, train

LINES = st.lists(st.tuples(st.floats(0.2, 8), st.floats(0, np.pi)), min_size=1, max_size=12)


def ends(lines: list[tuple[float, float]], turn: float = 0.0) -> np.ndarray:
    return np.array([[[0, 0], [s * np.cos(a + turn), s * np.sin(a + turn)]] for s, a in lines])


@given(LINES)
def test_the_histogram_peaks_at_one_in_the_middle(lines: list[tuple[float, float]]) -> None:
    histogram, _ = angle_histogram(ends(lines), 36)
    assert histogram[18] == histogram.max() == 1


@given(LINES, st.integers(0, 71))
def test_turning_the_room_does_not_change_its_histogram(lines: list[tuple[float, float]], steps: int) -> None:
    before, _ = angle_histogram(ends(lines), 36)
    after, _ = angle_histogram(ends(lines, steps * np.pi / 36), 36)
    ties = np.sort(before)[-2:]
    if len(lines) == 1 or ties[1] - ties[0] > 1e-6:
        assert after == pytest.approx(before, abs=1e-6)


@pytest.mark.parametrize("turn", [0.0, 0.4, 1.5, 3.0])
def test_a_rectangle_has_two_axes_the_longer_first(turn: float) -> None:
    lines = ends([(6, 0.0), (6, 0.0), (3, np.pi / 2), (3, np.pi / 2)], turn)
    first, second = main_axes(lines, *angle_histogram(lines, 36))
    assert np.cos(2 * (first - turn)) == pytest.approx(1, abs=1e-3)
    assert np.cos(2 * (second - turn)) == pytest.approx(-1, abs=1e-3)


def test_walls_all_of_one_slope_give_one_axis() -> None:
    lines = ends([(6, 0.3), (5, 0.3)])
    first, second = main_axes(lines, *angle_histogram(lines, 36))
    assert first == pytest.approx(0.3, abs=1e-3)
    assert np.isnan(second)


def test_other_bin_counts_fit_the_network() -> None:
    lines = ends([(6, 0.0), (3, np.pi / 2)])
    fine = resample(angle_histogram(lines, 90)[0])
    assert fine.shape == (36,)
    assert fine.argmax() == 18
    assert fine[0] > 0.2


def test_hallway_and_rooms_of_the_building(building: Building) -> None:
    found = classify(building.lines, building.places, building.free, Settings())
    assert found.best[building.at(1, 1)] in ("CDMA", "ODMA")
    assert found.best[building.at(2.5, 3)] == "TOMA"
    assert found.scores.sum(1) == pytest.approx(np.ones(3))
    assert found.histogram.shape == (3, 36)


def test_the_shipped_network_knows_rooms_it_has_not_seen() -> None:
    rng = np.random.default_rng(12345)
    inputs, labels = zip(*(sample(rng) for _ in range(1500)), strict=True)
    right = network().probabilities(np.array(inputs)).argmax(1) == np.array(labels)
    for k, name in enumerate(CLASSES):
        assert right[np.array(labels) == k].mean() > 0.85, name


def test_training_repeats_itself() -> None:
    first, _ = train(seed=3, samples=300)
    again, _ = train(seed=3, samples=300)
    for a, b in zip(first.weights, again.weights, strict=True):
        assert (a == b).all()


def test_a_network_survives_its_file(tmp_path) -> None:  # type: ignore[no-untyped-def]
    rng = np.random.default_rng(0)
    layers = (rng.normal(size=(5, 4)), rng.normal(size=(4, 3)))
    net = Network(np.zeros(5), np.ones(5), layers, (np.zeros(4), np.zeros(3)))
    net.save(tmp_path / "net.npz")
    x = rng.normal(size=(7, 5))
    assert Network.load(tmp_path / "net.npz").probabilities(x) == pytest.approx(net.probabilities(x), abs=1e-5)


def test_the_shipped_weights_are_those_of_the_script() -> None:
    """To float32 here; other processors sum in another order, which may move scores by a few percent."""
    found, confusion = train()
    inputs, _ = samples_of(np.random.default_rng(5), 400)
    assert np.abs(found.probabilities(inputs) - network().probabilities(inputs)).mean() < 0.01
    assert confusion.trace() / confusion.sum() > 0.93


def test_scores_can_be_believed() -> None:
    inputs, true = samples_of(np.random.default_rng(77), 3000)
    p = network().probabilities(inputs)
    score, right = p.max(1), p.argmax(1) == true
    for low, high in ((0.4, 0.8), (0.8, 0.95), (0.95, 1.01)):
        band = (score >= low) & (score < high)
        assert score[band].mean() == pytest.approx(right[band].mean(), abs=0.08)
