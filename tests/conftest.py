"""Data recorded by others lies beside the checkout; tests that need it skip without.

Properties are tried on the same cases every time, so that a slow machine or a lucky draw fails
nobody's first run; `pytest --hypothesis-profile=default` draws new ones.

Bytecode is written even where a variable forbids it: every worker would rewrite all assertions.
"""

import gc
import os
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, settings

sys.dont_write_bytecode = False
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
settings.register_profile(
    "repeatable",
    deadline=None,
    derandomize=True,
    max_examples=50,
    suppress_health_check=[HealthCheck.too_slow],  # beside busy neighbours all may be
)
settings.load_profile("repeatable")


def pytest_collection_finish() -> None:
    """Thousands of tests are kept to the end: no garbage collection has to look at them."""
    gc.collect()
    gc.freeze()


@pytest.fixture(scope="session")
def shared_data() -> Path:
    default = Path(__file__).resolve().parents[2] / "shared" / "data"
    folder = Path(os.environ.get("SKINFIELD_SHARED_DATA", default))
    if not folder.is_dir():
        pytest.skip(f"no recordings of others at {folder}: set SKINFIELD_SHARED_DATA to use them")
    return folder


@pytest.fixture
def engine() -> Iterator[Any]:
    """Ring of an engine that publishes a cycle whenever it is told to."""
    from recorder_ring import FakeEngine

    with FakeEngine() as made:
        yield made
