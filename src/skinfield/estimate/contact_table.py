"""The table of contacts: one row per contact, in SI units; a reading without one has none."""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import SkinfieldError, needs
from skinfield.estimate.contact import Contact
from skinfield.estimate.tracked import TrackedContact

if TYPE_CHECKING:
    import pandas

WORDS = ("solver", "shape", "scale", "body_part", "skin_part")
WHOLE = ("reading", "stamp_ns", "valid_taxels", "contact", "track", "link")
READING = ("reading", "stamp_ns", "time_s", "total_force_N", "solver", "valid_taxels")
CONTACT = (
    *("x_m", "y_m", "z_m", "place_std_m", "fx_N", "fy_N", "fz_N", "force_N", "force_std_N"),
    *("area_m2", "peak_pressure_Pa", "axis_major_m", "axis_minor_m", "angle_rad"),
    *("shape", "radius_m"),
)
COLUMNS = (*READING, "contact", *CONTACT, "scale")
LISTED = (*COLUMNS, "track", "body_part", "link", "skin_part")  # of contacts of other programs
KINDS, LISTED_KINDS = (
    [(n, np.dtype("i8" if n in WHOLE else "U" if n in WORDS else "f8")) for n in names]
    for names in (COLUMNS, LISTED)
)
SENT = "sent"  # solver of contacts that another program found, and scale of their forces
NEWTONS, RELATIVE = "newtons", "relative"  # scale of forces: known, or up to one factor


def scale_of(relative: bool) -> str:
    """What forces are, in a word: newtons, or relative, where they hold up to one factor."""
    return RELATIVE if relative else NEWTONS


class Answer(Protocol):
    """What rows are made of: an estimate, or what its contacts keep of it."""

    @property
    def is_batch(self) -> bool: ...  # noqa: D102
    @property
    def normal_force(self) -> Any: ...  # noqa: D102

    @property
    def valid(self) -> Any: ...  # noqa: D102
    @property
    def stamp_ns(self) -> Any: ...  # noqa: D102
    @property
    def solver(self) -> Any: ...  # noqa: D102
    @property
    def relative(self) -> bool: ...  # noqa: D102
    @property
    def contacts(self) -> Any: ...  # noqa: D102


Value = int | float | str | None
Row = tuple[Value, ...]


def rows_from_estimate(estimate: Answer, first: int, start_ns: int) -> Iterator[Row]:
    """Rows in the order of `COLUMNS`; `first` is the number of the estimate's first reading.

    `start_ns` is where `time_s` is 0. None stands for a value that is not there.
    """
    forces = np.atleast_1d(estimate.normal_force)
    counted = np.count_nonzero(estimate.valid, axis=-1)
    valid = np.broadcast_to(counted, len(forces)).tolist()
    stamps = np.broadcast_to(estimate.stamp_ns, len(forces)).tolist()
    each = estimate.contacts if estimate.is_batch else (estimate.contacts,)
    names = np.broadcast_to(estimate.solver, len(forces)).tolist()
    scale = scale_of(estimate.relative)
    every = zip(forces.tolist(), stamps, names, each, strict=True)
    for k, (force, stamp, name, contacts) in enumerate(every):
        reading = (first + k, stamp, (stamp - start_ns) / 1e9, _or_none(force), name, valid[k])
        for number, contact in enumerate(contacts):
            yield (*reading, number, *map(_or_none, _values(contact)), scale)


def rows_from_tracks(
    tracks: Iterable[TrackedContact], reading: int, stamp_ns: int, start_ns: int
) -> Iterator[Row]:
    """Rows in the order of `LISTED`: contacts of a `ContactList`, as sent, with their tracks."""
    seen: list[tuple[int | None, Any]] = [
        (one.track_id, one.measured) for one in tracks if not one.is_coasting
    ]
    seen.sort(key=lambda each: -each[1].normal_force)
    force, taxels = sum(one.normal_force for _, one in seen), sum(one.taxels for _, one in seen)
    first = (reading, stamp_ns, (stamp_ns - start_ns) / 1e9, _or_none(force), SENT, taxels)
    for place, (track, one) in enumerate(seen):
        values = map(_or_none, _values(one))
        yield (*first, place, *values, SENT, track, one.body, one.link, one.skin)


def _values(contact: Contact) -> tuple[float | str, ...]:
    return (
        *contact.position.tolist(),
        contact.place_std,
        *contact.force.tolist(),
        contact.normal_force,
        contact.force_std,
        contact.area,
        contact.peak_pressure,
        *contact.axes.tolist(),
        contact.angle,
        contact.shape,
        contact.radius,
    )


def _or_none(value: float | str) -> float | str | None:
    if isinstance(value, str):
        return value
    return float(value) if np.isfinite(value) else None


@dataclass(frozen=True, eq=False)
class ContactTable:
    """Table of contacts as a CSV file holds it: SI units, which stand in the names of the columns.

    Attributes
    ----------
    columns : mapping of str to (N,) array
        Numbers, whole where none is missing, and words; NaN where a number is missing.
    """

    columns: Mapping[str, NDArray[Any]]

    @property
    def column_names(self) -> list[str]:
        """Names of the columns, in their order."""
        return list(self.columns)

    def __len__(self) -> int:
        return len(self["reading"])

    def __getitem__(self, name: str) -> NDArray[Any]:
        return self.columns[name]

    def __repr__(self) -> str:
        return f"ContactTable({len(self)} contacts, {len(self.columns)} columns)"

    def to_pandas(self) -> "pandas.DataFrame":
        """Data frame of the same columns; raises InputError if pandas is not installed."""
        with needs("pandas", "pandas", "data frames"):
            import pandas

        kinds = {
            name: object if v.dtype.kind == "U" else v.dtype for name, v in self.columns.items()
        }
        return pandas.DataFrame(
            {name: pandas.Series(v, dtype=kinds[name]) for name, v in self.columns.items()}
        )


def load_pyarrow() -> Any:
    """The pyarrow package; raises SkinfieldError if it is not installed."""
    try:
        import pyarrow
        import pyarrow.parquet
    except ImportError as error:
        raise SkinfieldError(
            "Parquet needs pyarrow, which is not installed: pip install 'skinfield[parquet]', "
            "or write .csv"
        ) from error
    return pyarrow
