"""What many tests share: the demo building, mapped once."""

from __future__ import annotations

import pytest
from hypothesis import settings

from rgcore.pipeline import Run, run
from rgcore.scans.read import read_log
from rgviz.demo import LOG

settings.register_profile("rgviz", deadline=None)  # a first call compiles a kernel
settings.load_profile("rgviz")


@pytest.fixture(scope="session")
def office() -> Run:
    """The demo log, through the whole pipeline with the default settings."""
    return run(read_log(LOG))
