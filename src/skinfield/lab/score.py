"""Scores of estimates: contacts matched to true ones, fields on one lattice, and summaries."""

import csv
import io
import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from skinfield.errors import Floats, InputError, check_positive
from skinfield.estimate import Contact, Estimate
from skinfield.files.pending import write_bytes
from skinfield.lab.cases import Case, TrueContact
from skinfield.skin import Grid, Patch

STEP = 0.5e-3  # m: side of the lattice's cells
BLUR = 2e-3  # m: standard deviation of the Gaussian, below which taxels see next to nothing
FINE = 6  # parts of a step: wider ones beat against the lattice, by 6 % where they are halves
MARGIN = 3  # standard deviations around what is compared


@dataclass(frozen=True)
class Lattice:
    """Regular points of the plane, at whole multiples of `STEP`.

    Parameters
    ----------
    first : (column, row)
        Of the first point, in steps from the plane's origin.
    shape : (rows, columns)
    """

    first: tuple[int, int]
    shape: tuple[int, int]

    @classmethod
    def around(cls, low: Floats, high: Floats) -> "Lattice":
        """Lattice over the rectangle from `low` to `high` (2,) m and a margin for the blur."""
        margin = MARGIN * BLUR + 2 * STEP
        start = np.floor((low - margin) / STEP).astype(int)
        stop = np.ceil((high + margin) / STEP).astype(int)
        columns, rows = (stop - start + 1).tolist()
        return cls((int(start[0]), int(start[1])), (rows, columns))

    def deposit(self, plane: Floats, values: Floats, cell: float) -> Floats:
        """Pressure (rows, columns) Pa of cells at (K, 2) m with `values` (K,) Pa.

        Each cell is split into squares of a sixth of a step at most; the force of each is shared
        among the four points around it in bilinear proportion. Force and first moment stay.
        """
        rows, columns = self.shape
        offsets = _offsets(cell)
        inner = np.stack(np.meshgrid(offsets, offsets), axis=-1).reshape(-1, 2)
        place = (plane[:, None] + inner).reshape(-1, 2) / STEP - self.first
        force = np.repeat(values * (cell / STEP) ** 2 / len(inner), len(inner))
        whole = np.floor(place).astype(np.int64)
        x, y = (place - whole).T
        corner = whole[:, 1] * columns + whole[:, 0]
        shares = (
            (0, (1 - x) * (1 - y)), (1, x * (1 - y)), (columns, (1 - x) * y), (columns + 1, x * y),
        )  # fmt: skip
        total = [np.bincount(corner + n, share * force, rows * columns) for n, share in shares]
        return np.asarray(np.sum(total, axis=0).reshape(rows, columns))

    def of_grid(self, grid: Grid, pressure: Floats) -> Floats:
        """Pressure (K,) Pa of a grid's cells as `deposit` has it, by two matrices."""
        x, y = (float(value) for value in grid.origin)
        along_y = _along(y, grid.shape[0], grid.pitch, self.first[1], self.shape[0])
        along_x = _along(x, grid.shape[1], grid.pitch, self.first[0], self.shape[1])
        return np.asarray(along_y @ pressure.reshape(grid.shape) @ along_x.T)


def blurred(values: Floats) -> Floats:
    """Values (rows, columns) of a lattice after a Gaussian of standard deviation `BLUR`."""
    from scipy.ndimage import gaussian_filter

    soft = gaussian_filter(values, BLUR / STEP, mode="constant", truncate=2 * MARGIN)
    return np.asarray(soft, dtype=np.float64)


def _offsets(cell: float) -> Floats:
    """Middles of the parts of a cell from its own, m."""
    parts = max(int(np.ceil(FINE * cell / STEP - 1e-9)), 1)
    return np.asarray((np.arange(parts) - (parts - 1) / 2) * (cell / parts))


@lru_cache(maxsize=128)
def _along(origin: float, count: int, pitch: float, first: int, points: int) -> Floats:
    """Shares (lattice points, cells) of each cell's pressure along one axis."""
    place = (origin + np.arange(count)[:, None] * pitch + _offsets(pitch)) / STEP
    apart = np.abs((np.arange(points) + first)[:, None, None] - place)
    return np.asarray(np.maximum(1 - apart, 0.0).mean(axis=2) * pitch / STEP)


Row = dict[str, Any]  # flat, with the unit in each key's name
MEASURES = (  # columns of rows that are summarised by their size
    "force_error",
    "total_force_error",
    "place_error_mm",
    "contact_force_error",
    "peak_error",
    "pressure_error",
    "blurred_pressure_error",
    "deformation_error",
    "area_error",
    "cold_ms",
    "warm_ms",
)
RATES = ("missed", "false_share", "false_per_reading", "idle_touched")
RESAMPLES = 999


def where(rows: Sequence[Row], **wanted: object) -> list[Row]:
    """Rows that hold these values under these keys."""
    return [row for row in rows if all(row[key] == value for key, value in wanted.items())]


def column(rows: Sequence[Row], key: str) -> Floats:
    """Numbers of a column, NaN where there is none."""
    values = [row.get(key) for row in rows]
    return np.array([np.nan if value is None else value for value in values], dtype=np.float64)


def wilson(hits: int, trials: int, sigmas: float = 1.96) -> tuple[float, float]:
    """Interval of a rate from hits in trials (Wilson 1927); 95 % by default."""
    rate, square = hits / trials, sigmas**2 / trials
    middle = (rate + square / 2) / (1 + square)
    half = sigmas / (1 + square) * np.sqrt(rate * (1 - rate) / trials + square / (4 * trials))
    return max(float(middle - half), 0.0), min(float(middle + half), 1.0)


def rate_row(name: str, hits: int, trials: int) -> Row:
    """Share of hits, and the ends of Wilson's interval; NaN where nothing was tried."""
    low, high = wilson(hits, trials) if trials else (math.nan, math.nan)
    return {name: hits / trials if trials else math.nan, f"{name}_low": low, f"{name}_high": high}


def quantiles(rows: Sequence[Row]) -> Row:
    """Median and 90th percentile of the size of each measure in the rows; NaN is left out."""
    out: Row = {}
    for name in [name for name in MEASURES if name in rows[0]]:
        values = np.abs(column(rows, name))
        values = values[np.isfinite(values)]
        median, p90 = np.quantile(values, [0.5, 0.9]) if len(values) else (math.nan, math.nan)
        out |= {f"{name}_median": float(median), f"{name}_p90": float(p90)}
    return out


def median_interval(
    values: Floats, resamples: int = RESAMPLES, seed: int = 0
) -> tuple[float, float]:
    """Percentile bootstrap interval of 95 % of the median of values (N,), NaN left out."""
    known = values[np.isfinite(values)]
    if len(known) < 2:
        return math.nan, math.nan
    rng = np.random.default_rng(seed)
    drawn = known[rng.integers(len(known), size=(resamples, len(known)))]
    low, high = np.quantile(np.median(drawn, axis=1), [0.025, 0.975])
    return float(low), float(high)


def summarise(rows: Sequence[Row], resamples: int = RESAMPLES, seed: int = 0) -> Row:
    """Summarise rows of single readings, such as a `Judge` makes.

    Intervals speak for cases like these, not for the model that made them.

    Parameters
    ----------
    rows : sequence of dict
        At least one, all with the same keys.
    resamples : int
        Of the bootstrap.
    seed : int
        Of its random numbers: the same rows give the same intervals.

    Returns
    -------
    dict
        ``_median``, ``_low`` and ``_high`` are the median of a measure's size and its 95 %
        interval, ``_p90`` the 90th percentile. ``force_bias`` is the median with its sign.
        ``missed`` is a share of the contacts, ``false_share`` of the readings with at least one
        contact that is not there, ``count_right`` those with as many as there are, and
        ``idle_touched``, where there are some, those of nothing in which something is found, all
        with Wilson's interval; ``false_per_reading`` is a mean.
    """
    if not rows:
        raise InputError("rows is empty, expected at least one")
    contacts = sum(row["contacts"] for row in rows)
    out: Row = {"readings": len(rows), "contacts": contacts} | quantiles(rows)
    for name in [name for name in MEASURES if name in rows[0]]:
        low, high = median_interval(np.abs(column(rows, name)), resamples, seed)
        out |= {f"{name}_low": low, f"{name}_high": high}
    errors = column(rows, "force_error")
    known = errors[np.isfinite(errors)]
    out["force_bias"] = float(np.median(known)) if len(known) else math.nan
    out |= rate_row("missed", sum(row["missed"] for row in rows), contacts)
    out |= rate_row("false_share", sum(row["false"] > 0 for row in rows), len(rows))
    right = sum(row["matched"] + row["false"] == row["contacts"] for row in rows)
    out |= rate_row("count_right", right, len(rows))
    idle = where(rows, contacts=0)
    if idle:
        out |= rate_row("idle_touched", sum(row["false"] > 0 for row in idle), len(idle))
    return out | {"false_per_reading": float(np.mean([row["false"] for row in rows]))}


def rows_by_case(rows: Sequence[Row]) -> list[Row]:
    """One row per case, noise and method: medians over its readings, and means of its counts."""
    groups: dict[tuple[Any, ...], list[Row]] = {}
    for row in rows:
        same = (row.get("file"), row["case"], row["quantity"], row["noise"], row["method"])
        groups.setdefault(same, []).append(row)
    return [
        {"readings": len(mine)} | {key: _middle([row[key] for row in mine]) for key in mine[0]}
        for mine in groups.values()
    ]


def _middle(values: list[Any]) -> Any:
    """Mean of counts, median of other numbers that are not NaN, and texts as they are."""
    if not isinstance(values[0], int | float):
        return values[0]
    known = [value for value in values if not math.isnan(value)] or [math.nan]
    return float(np.mean(known) if isinstance(values[0], int) else np.median(known))


def write_csv(rows: Sequence[Row], path: str | Path) -> None:
    """Write rows under the keys of all of them, whole or not at all; NaN and None stay empty.

    Raises
    ------
    FileError
        If the file cannot be written.
    """
    keys = list(dict.fromkeys(key for row in rows for key in row))
    buffer = io.StringIO()
    writer = csv.DictWriter(buffer, keys, lineterminator="\n")
    writer.writeheader()
    for row in rows:
        writer.writerow({key: _csv_cell(value) for key, value in row.items()})
    write_bytes(path, buffer.getvalue().encode())


def _csv_cell(value: Any) -> Any:
    if isinstance(value, float):
        return f"{value:.6g}" if math.isfinite(value) else ""
    return "" if value is None else value


GATE = 8e-3  # m: farther apart, two contacts do not belong together


@dataclass(frozen=True)
class Match:
    """A true contact and the estimated one that belongs to it.

    Attributes
    ----------
    true, estimated : int
        Their places in the two lists.
    distance : float, m
    force_error : float
        Signed, part of the true force.
    """

    true: int
    estimated: int
    distance: float
    force_error: float


def matched(
    patch: Patch, true: Sequence[TrueContact], found: Sequence[Contact], gate: float = GATE
) -> tuple[tuple[Match, ...], int, int]:
    """Assign found contacts to true ones: as many pairs as the gate allows, then the nearest.

    Parameters
    ----------
    patch : Patch
        On which the true contacts' positions lie.
    true : sequence of TrueContact
    found : sequence of Contact
    gate : float, m

    Returns
    -------
    matches : tuple of Match
        In the order of the true contacts.
    missed, false : int
        True contacts and found ones that are left over.
    """
    if not true or not found:
        return (), len(true), len(found)
    from scipy.optimize import linear_sum_assignment

    plane = np.array([contact.position for contact in true])
    places = patch.surface.position_from_plane(plane)
    positions = np.array([contact.position for contact in found])
    apart = np.linalg.norm(places[:, None] - positions[None], axis=2)
    # A pair beyond the gate costs more than all pairs within it: it is only made if no other is.
    beyond = gate * (min(apart.shape) + 1)
    rows, columns = linear_sum_assignment(np.where(apart <= gate, apart, beyond))
    matches = tuple(
        Match(i, j, float(apart[i, j]), float(found[j].normal_force) / true[i].force - 1)
        for i, j in zip(rows.tolist(), columns.tolist(), strict=True)
        if apart[i, j] <= gate
    )
    return matches, len(true) - len(matches), len(found) - len(matches)


@dataclass(frozen=True, eq=False)
class Judge:
    """The truth of a case, prepared for estimates on one grid: many solvers, many readings.

    Truth and estimate are brought onto one lattice of 0.5 mm: each cell's force is shared among
    the four nearest points in bilinear proportion, which keeps the force and its place. The
    indentation is compared at the truth's nodes, where the estimate's is interpolated.

    Parameters
    ----------
    case : Case
    grid : Grid
        Of the estimates, on the case's patch or an equal one.
    gate : float, m
        True and found contacts belong together by the assignment of the smallest sum of distances,
        each below this.
    """

    case: Case
    grid: Grid
    gate: float = GATE

    def __post_init__(self) -> None:
        check_positive("gate", self.gate, "distance up to which contacts may belong together, m")
        taxels = len(self.grid.patch)
        if taxels != len(self.case.patch):
            raise InputError(
                f"the grid lies on a patch of {taxels} taxels, expected one of "
                f"{len(self.case.patch)}, as the case {self.case.name!r} has"
            )

    @cached_property
    def lattice(self) -> Lattice:
        """Over grid and truth."""
        truth, half = self.case.truth, self.grid.pitch / 2
        low, high = self.grid.plane.min(axis=0) - half, self.grid.plane.max(axis=0) + half
        loaded = truth.plane[truth.pressure != 0]
        if len(loaded):
            low = np.minimum(low, loaded.min(axis=0) - truth.cell / 2)
            high = np.maximum(high, loaded.max(axis=0) + truth.cell / 2)
        return Lattice.around(low, high)

    @cached_property
    def pressure(self) -> tuple[Floats, Floats]:
        """True pressure on the lattice, Pa: as it is, and blurred."""
        truth, lattice = self.case.truth, self.lattice
        loaded = truth.pressure != 0
        raw = lattice.deposit(truth.plane[loaded], truth.pressure[loaded], truth.cell)
        return raw, blurred(raw)

    def __call__(self, estimate: Estimate, contacts: Sequence[Contact] | None = None) -> Row:
        """Score one estimate against the truth.

        Parameters
        ----------
        estimate : Estimate
            Of one reading.
        contacts : sequence of Contact, optional
            Default those of the estimate.

        Returns
        -------
        dict
            Errors by their names: parts of the truth, with a sign where there can be one, but for
            ``place_error_mm``. What cannot be said is NaN, as the place of a missed contact.
            ``contacts`` are those there are, ``matched`` those with a found one within the gate,
            ``missed`` those without, ``false`` the found ones without a true one. Forces and areas
            are of all contacts, ``total_force_error`` is of `Estimate.normal_force`; pressures are
            compared by norms of differences over that of the truth, as they are on the lattice and
            after a Gaussian of 2 mm standard deviation.
        """
        if estimate.is_batch:
            raise InputError("the estimate is of several readings, expected one: index it")
        found = estimate.contacts if contacts is None else contacts
        truth = self.case.truth
        matches, missed, false = matched(self.case.patch, truth.contacts, found, self.gate)
        sharp = self.lattice.of_grid(self.grid, estimate.pressure)
        exact, exact_blurred = self.pressure
        contacts_force = float(sum(contact.normal_force for contact in found))
        highest = float(exact.max()) if len(truth.plane) else 0.0
        return {
            "case": self.case.name,
            "true_force_N": truth.force,
            "contacts": len(truth.contacts),
            "matched": len(matches),
            "missed": missed,
            "false": false,
            "force_error": _relative(contacts_force, truth.force),
            "total_force_error": _relative(float(estimate.normal_force), truth.force),
            "place_error_mm": _mean([1e3 * match.distance for match in matches]),
            "contact_force_error": _mean([abs(match.force_error) for match in matches]),
            "peak_error": _relative(float(sharp.max()), highest),
            "pressure_error": _distance(sharp, exact),
            "blurred_pressure_error": _distance(blurred(sharp), exact_blurred),
            "deformation_error": self._deformation_error(estimate.indentation),
            "area_error": _relative(float(sum(c.area for c in found)), truth.contact_area),
        }

    @cached_property
    def _sunk(self) -> tuple[Floats, Floats]:
        """Rows and columns (2, N) of the grid where the true indentation (N,) m is known."""
        truth, grid = self.case.truth, self.grid
        place = (truth.plane - grid.origin) / grid.pitch
        known = np.isfinite(truth.displacement[:, 2])
        known &= ((place >= 0) & (place <= np.array(grid.shape[::-1]) - 1)).all(axis=1)
        return place[known].T[::-1], -truth.displacement[known, 2]

    def _deformation_error(self, indentation: Floats) -> float:
        from scipy.ndimage import map_coordinates

        where, exact = self._sunk
        return _distance(
            map_coordinates(indentation.reshape(self.grid.shape), where, order=1), exact
        )


def _relative(found: float, true: float) -> float:
    return found / true - 1 if true > 0 else math.nan


def _mean(values: list[float]) -> float:
    return float(np.mean(values)) if values else math.nan


def _distance(found: Floats, true: Floats) -> float:
    norm = float(np.linalg.norm(true))
    return float(np.linalg.norm(found - true)) / norm if norm > 0 else math.nan
