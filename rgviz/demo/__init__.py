"""The building that ships with rgviz: an office floor, the log of a simulated drive through it, and what is true of it.

``office.plan.json`` is written by hand; everything else is made from it, byte for byte, by

    rgviz simulate rgviz/demo/office.plan.json -o rgviz/demo/office.log.gz
"""

from __future__ import annotations

from pathlib import Path

PLAN = Path(__file__).with_name("office.plan.json")
LOG = Path(__file__).with_name("office.log.gz")
TRUTH = Path(__file__).with_name("office.truth.json")
POSES = Path(__file__).with_name("office.poses.tum")
ROOMS = Path(__file__).with_name("office.rooms.png")
