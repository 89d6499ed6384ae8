"""Data recorded by others lies beside the checkout; tests that need it skip without."""

import os
from pathlib import Path

import pytest


@pytest.fixture(scope="session")
def shared_data() -> Path:
    default = Path(__file__).resolve().parents[2] / "shared" / "data"
    folder = Path(os.environ.get("SKINFIELD_SHARED_DATA", default))
    if not folder.is_dir():
        pytest.skip(f"no recordings of others at {folder}: set SKINFIELD_SHARED_DATA to use them")
    return folder
