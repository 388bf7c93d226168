"""What many tests share: the demo building, mapped once."""

from __future__ import annotations

import os

import pytest
from hypothesis import settings

from rgcore.pipeline import Run, run
from rgcore.scans.read import read_log
from rgviz.demo import LOG

# No deadline: a first call compiles a kernel. The gate tries the same examples each time, a developer new ones.
settings.register_profile("rgviz", deadline=None, derandomize="CI" in os.environ)
settings.load_profile("rgviz")


@pytest.fixture(scope="session")
def office() -> Run:
    """The demo log, through the whole pipeline with the default settings."""
    return run(read_log(LOG))
