"""What class a place looks like while it is being mapped (paper, section IV-D).

The paper goes by the last k line scans. Those see through doors into other rooms and show a wall as often as scans
passed it; so the lines that the scans so far show of the region itself are merged and looked at, as in the batch.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import fields

import numpy as np

from rgcore.config import Config
from rgcore.lines.merge import merge_lines
from rgcore.places.classify import angle_histogram, measures, network, resample
from rgcore.places.places import Places
from rgcore.places.regions import describe, region_of_segments
from rgcore.places.sofar import PlacesSoFar
from rgcore.scans.extract import Segments
from rgcore.slam.trajectory import Trajectory

FEWEST = 4
"""Segments; what fewer show is no room yet."""


def look(
    places: PlacesSoFar, number: int, segments: Sequence[Segments], trajectory: Trajectory, config: Config
) -> np.ndarray | None:
    """(4,) chance of each class for region ``number``, from the segments of all keyframes; None if nothing is seen."""
    every = Segments(**{f.name: np.concatenate([getattr(s, f.name) for s in segments]) for f in fields(Segments)})
    own = every[region_of_segments(every, trajectory, Places(places.labels, (), ())) == number]
    if len(own) < FEWEST:
        return None
    lines, _ = merge_lines(own, trajectory, np.zeros(len(own), np.int64), config.lines)
    gateways = [g.found for g in places.gateways if g.found is not None and number in g.found.regions]
    region = describe(places.labels, number, -1, config.places)
    histogram, _ = angle_histogram(lines.ends, config.classes.histogram_bins)
    inputs = np.concatenate([resample(histogram), measures(region, [g.posts for g in gateways], lines.ends)])
    chance: np.ndarray = network().probabilities(inputs[None])[0]
    return chance
