"""Files of fields: NPZ and Zarr."""

import io
import json
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from skinfield.errors import SkinfieldError
from skinfield.fields import Estimate
from skinfield.sinks.field_series import (
    FIXED,
    SERIES,
    Arrays,
    attributes_of,
    fixed_of,
    readings_per_chunk,
)
from skinfield.sinks.pending import Pending, explained, write_bytes


@dataclass
class NpzStore:
    """Holds everything until the end: an NPZ file cannot grow."""

    place: Pending
    fixed: Arrays = field(default_factory=dict)
    attributes: dict[str, Any] = field(default_factory=dict)
    parts: list[Arrays] = field(default_factory=list)

    def begin(self, estimate: Estimate) -> None:
        """Write what all readings share."""
        self.fixed = fixed_of(estimate)
        units = {name: spec[2] for name, spec in {**SERIES, **FIXED}.items()}
        self.attributes = {**attributes_of(estimate.grid), "units": units}

    def append(self, series: Arrays) -> None:
        """Add readings."""
        self.parts.append(series)

    def finish(self) -> None:
        """Give the result its name."""
        series = {key: np.concatenate([part[key] for part in self.parts]) for key in SERIES}
        buffer = io.BytesIO()
        text = np.array(json.dumps(self.attributes))
        np.savez_compressed(buffer, allow_pickle=False, **series, **self.fixed, attributes=text)
        write_bytes(self.place.target, buffer.getvalue())

    def discard(self) -> None:
        """Remove what was written."""
        self.parts.clear()


@dataclass
class ZarrStore:
    """A Zarr group that grows chunk by chunk."""

    place: Pending
    zarr: Any
    group: Any = None

    def begin(self, estimate: Estimate) -> None:
        """Write what all readings share."""
        rows, columns = estimate.grid.shape
        sizes = {"row": rows, "column": columns, "axis": 3}
        count = readings_per_chunk(estimate.grid)
        with explained(self.place.target):
            self.group = self.zarr.create_group(
                self.place.part, attributes=attributes_of(estimate.grid)
            )
            for name, spec in SERIES.items():
                shape = tuple(sizes[axis] for axis in spec[1])
                self._create(name, spec, ("reading",), (0, *shape), (count, *shape))
            for name, spec in FIXED.items():
                shape = tuple(sizes[axis] for axis in spec[1])
                self._create(name, spec, (), shape, shape)
                self.group[name][...] = fixed_of(estimate)[name]

    def _create(
        self,
        name: str,
        spec: tuple[str, tuple[str, ...], str, str],
        lead: tuple[str, ...],
        shape: tuple[int, ...],
        chunks: tuple[int, ...],
    ) -> None:
        kind, axes, unit, meaning = spec
        self.group.create_array(
            name,
            shape=shape,
            chunks=chunks,
            dtype=kind,
            dimension_names=(*lead, *axes),
            attributes={"units": unit, "long_name": meaning},
        )

    def append(self, series: Arrays) -> None:
        """Add readings."""
        with explained(self.place.target):
            for name, values in series.items():
                self.group[name].append(values)

    def finish(self) -> None:
        """Give the result its name."""
        self.place.commit()

    def discard(self) -> None:
        """Remove what was written."""
        self.place.discard()


def load_zarr() -> Any:
    """The zarr package; raises SkinfieldError if it is not installed."""
    try:
        import zarr
    except ImportError as error:
        raise SkinfieldError(
            "Zarr needs zarr, which is not installed: pip install 'skinfield[zarr]', or write .npz"
        ) from error
    return zarr
