"""What makes a recording self-contained: layout, calibrations, configuration, as small files."""

import json
from collections.abc import Iterator, Mapping
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from skinfield.acquisition.recorded import (
    CALIBRATION,
    CONFIGURATION,
    DESCRIPTION,
    LAYOUT,
    Enclosed,
)
from skinfield.conditioning import Calibration
from skinfield.layout import Skin

NPZ, JSON = "application/x-npz", "application/json"


def enclosures(
    skin: Skin | None = None,
    calibrations: Mapping[str, Calibration] | None = None,
    configuration: Mapping[str, Any] | None = None,
    description: Mapping[str, Any] | None = None,
) -> tuple[Enclosed, ...]:
    """Files that `RecordingWriter` encloses and `LiveRecording` reads.

    Parameters
    ----------
    skin : Skin, optional
        As skinfield's own NPZ layout: nothing of it is lost.
    calibrations : mapping of str to Calibration, optional
        By patch.
    configuration : mapping, optional
        How the engine was run, as JSON can hold it.
    description : mapping, optional
        Of the ring, likewise.
    """
    return tuple(_enclosed(skin, calibrations or {}, configuration, description))


def _enclosed(
    skin: Skin | None,
    calibrations: Mapping[str, Calibration],
    configuration: Mapping[str, Any] | None,
    description: Mapping[str, Any] | None,
) -> Iterator[Enclosed]:
    from skinfield.conditioning import save_calibration
    from skinfield.layout.formats import own_npz

    with TemporaryDirectory() as folder:
        path = Path(folder) / "enclosed.npz"
        if skin is not None:
            own_npz.write(skin, path)
            yield Enclosed(LAYOUT, NPZ, path.read_bytes())
        for patch, calibration in calibrations.items():
            save_calibration(calibration, path)
            yield Enclosed(CALIBRATION.format(patch=patch), NPZ, path.read_bytes())
    for name, value in ((CONFIGURATION, configuration), (DESCRIPTION, description)):
        if value is not None:
            yield Enclosed(name, JSON, json.dumps(value, indent=1).encode())
