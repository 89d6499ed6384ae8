"""Contacts of an estimate: a sequence of them, as a table and as a data frame."""

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

import numpy as np

from skinfield.errors import needs
from skinfield.estimate.contact import Contact
from skinfield.estimate.contact_table import COLUMNS, KINDS, rows_from_estimate
from skinfield.plot import html_table, number

if TYPE_CHECKING:
    import pandas

MOST_SHOWN = 20  # rows of a table in a notebook
HEAD = ["place (mm)", "force (N)", "area (mm²)", "peak (kPa)", "shape"]


class Contacts(tuple[Any, ...]):
    """Contacts in order of falling force; of a run of readings, those of each reading.

    It is a tuple, and keeps of its estimate what the table of contacts says of a reading.

    Attributes
    ----------
    is_batch : bool
        Whether it is of a run of T readings: T of these.
    normal_force : float or (T,) array, N
        Of all contacts of a reading, or of the field that answered.
    stamp_ns : int or (T,) int64 array, ns
    valid : ([T,] L) bool array
        Taxels that were used.
    solver : str, or T of them
    relative : bool
        Whether forces hold up to one factor only.

    Examples
    --------
    >>> import skinfield as sf
    >>> recorded = sf.datasets.load("two_presses")
    >>> rec = sf.Reconstructor(recorded.patch, calibration=recorded.calibration)
    >>> frame = rec(recorded.recording.counts[recorded.peak]).contacts.to_pandas()
    >>> [column for column in frame.columns if column.endswith("_N")]
    ['total_force_N', 'fx_N', 'fy_N', 'fz_N', 'force_N', 'force_std_N']
    """

    is_batch: bool
    normal_force: Any
    stamp_ns: Any
    valid: Any
    solver: Any
    relative: bool

    @classmethod
    def of(cls, estimate: Any, contacts: Iterable[Any]) -> "Contacts":
        """Contacts of an estimate: `Contact`s, or of T readings so many tuples of them."""
        if estimate.is_batch:
            each = [one if isinstance(one, cls) else cls(one) for one in contacts]
            made = cls(each)
            sums: Any = np.array([_sum(one) for one in each])
        else:
            made = cls(contacts)
            sums = np.float64(_sum(made))
        field = estimate.is_field
        force = sums if not np.any(field) else np.where(field, estimate._field_force, sums)
        made.__dict__.update(
            is_batch=estimate.is_batch,
            normal_force=force if estimate.is_batch else float(force),
            stamp_ns=estimate.stamp_ns,
            valid=estimate.valid,
            solver=estimate.solver,
            relative=estimate.relative,
        )
        return made

    @property
    def contacts(self) -> "Contacts":
        """These: rows of the table are made of an estimate or of its contacts."""
        return self

    def to_pandas(self) -> "pandas.DataFrame":
        """One row per contact, and reading; a reading without a contact has none.

        Returns
        -------
        pandas.DataFrame
            The columns of the table of contacts (`skinfield reconstruct -o contacts.csv`), SI units
            in their names: reading (its row in the run), stamp_ns, time_s since the first, ...
            Without the two of time where the readings had no stamps.

        Raises
        ------
        InputError
            If pandas is not installed.
        """
        with needs("pandas", "pandas", "data frames"):
            import pandas

        first = int(np.ravel(self.stamp_ns)[0]) if np.size(self.stamp_ns) else 0
        rows = list(rows_from_estimate(self, 0, first))
        columns = {name: [row[place] for row in rows] for place, name in enumerate(COLUMNS)}
        timed = np.any(self.stamp_ns)
        names = [name for name in COLUMNS if timed or name not in ("stamp_ns", "time_s")]
        kinds = {name: object if kind.kind == "U" else kind for name, kind in KINDS}
        return pandas.DataFrame(
            {name: pandas.Series(columns[name], dtype=kinds[name]) for name in names}
        )

    def _repr_html_(self) -> str:
        """Table of the contacts, units in its head."""
        flat = [(str(k), c) for k, one in enumerate(self) for c in one] if self._deep else []
        rows = flat or [(str(k + 1), c) for k, c in enumerate(self) if not self._deep]
        names = [name.replace("N", "relative") if self._loose else name for name in HEAD]
        cells = [[name, *_cells(contact)] for name, contact in rows[:MOST_SHOWN]]
        if len(rows) > MOST_SHOWN:
            cells.append(["…", f"{len(rows) - MOST_SHOWN} more", *[""] * (len(HEAD) - 1)])
        return html_table(cells, ["reading" if self._deep else "", *names])

    @property
    def _deep(self) -> bool:
        return bool(vars(self).get("is_batch", False))

    @property
    def _loose(self) -> bool:
        return bool(vars(self).get("relative", False))


def _sum(contacts: Iterable[Contact]) -> float:
    return sum((contact.normal_force for contact in contacts), 0.0)


def _cells(contact: Contact) -> list[str]:
    return [*contact._words(), number(contact.peak_pressure * 1e-3), contact.shape]
