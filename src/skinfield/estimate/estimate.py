"""Estimate of a patch: fields and contacts of one reading, or of a run of them."""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import nullcontext
from dataclasses import dataclass, field, replace
from functools import partial
from threading import RLock
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import Floats, InputError
from skinfield.estimate.contact import Contact
from skinfield.estimate.contacts import Contacts
from skinfield.estimate.wrench import Wrench
from skinfield.plot import Pictured, Place, drawing, number, plural
from skinfield.skin import Grid


@dataclass(frozen=True, eq=False, repr=False)
class Estimate(Pictured):
    """Fields and contacts from one reading, or from T readings at once (a leading axis T).

    Vectors are in the patch's frame. Indexing and iterating over an estimate of T readings gives
    the estimate of each.

    Attributes
    ----------
    grid : Grid
        The K nodes.
    pressure : ([T,] K) array, Pa
        Normal part of the traction, positive in compression.
    traction : ([T,] K, 3) array, Pa
        Force per area on the skin.
    displacement : ([T,] K, 3) array, m
        Of the skin's surface, normal and tangential.
    pressure_std : ([T,] K) array, Pa
        One standard deviation of `pressure` as the solver states it.
    contacts : Contacts
        A tuple of `Contact` in order of falling force, or of T such tuples; ``to_pandas()`` makes
        a data frame of it.
    residual : ([T,] L) array
        Linearised reading minus what the pressure predicts, in the quantity's unit; NaN for taxels
        that were left out.
    valid : ([T,] L) bool array
        Taxels that were used.
    readings : ([T,] L) array, in the quantity's unit
        As measured; of taxels that were left out what they would read, by the answer and by their
        neighbours.
    readings_std : ([T,] L) array, in the quantity's unit
        One standard deviation: of measured ones their noise, of the others how far the reading of
        a taxel that works would be off.
    latency : float, s
        From the reading to the pressure, for the whole call.
    stamp_ns : int or (T,) int64 array, ns
        Of the reading, where it was given; else 0.
    gap : float or (T,) array, dimensionless
        Share of its objective by which the answer may be above the minimum, at most, which is
        proved: 0 where the answer is a closed form, NaN where nothing is proved. An idle patch is
        answered by the exact minimum of its problem, with the whole detection threshold as penalty
        (`NonNegative`): 0.
    iterations : int or (T,) array
        Steps that an iterative solver took.
    deadline_met : bool or (T,) array
        Whether the pressure was there in time; so it is where no deadline was set.
    notes : tuple of str
    solver : str, or T of them
        Name of the solver that answered: of `Auto` the one that it chose.
    is_field : bool or (T,) array
        Whether a pressure field answered, in which contacts are found; else contacts were fitted,
        and the field is what they press.
    relative : bool
        Whether forces and pressures hold up to one factor only, as nothing known gave the scale.

    An estimate may be prompt: pressure and gap are there, and the rest, such as displacement and
    contacts, is computed when it is first asked for; see `later`.
    """

    grid: Grid
    pressure: Floats
    traction: Floats
    displacement: Floats
    pressure_std: Floats
    contacts: Any
    residual: Floats
    valid: NDArray[np.bool_]
    readings: Floats
    readings_std: Floats
    latency: float = float("nan")
    stamp_ns: Any = 0
    notes: tuple[str, ...] = field(default=())
    gap: Any = float("nan")
    iterations: Any = 0
    deadline_met: Any = True
    solver: Any = ""
    is_field: Any = True
    relative: bool = False

    def __post_init__(self) -> None:
        vars(self)["contacts"] = Contacts.of(self, self.contacts)

    @classmethod
    def joined(cls, each: Sequence["Estimate"], **known: Any) -> "Estimate":
        """Estimate of T readings from that of each, stacked when it is looked at.

        Parameters
        ----------
        each : T Estimate
            Of one reading each, in order.
        known
            Attributes of all.
        """

        def stacked(name: str) -> Any:
            values = [getattr(one, name) for one in each]
            return tuple(values) if name == "contacts" else np.stack(values)

        estimate = cls.later(
            {name: partial(stacked, name) for name in REQUIRED - {"grid"}},
            grid=each[0].grid,
            **{name: stacked(name) for name in ("gap", "iterations", "deadline_met", "is_field")},
            notes=tuple(dict.fromkeys(note for one in each for note in one.notes)),
            solver=tuple(one.solver for one in each),
            relative=each[0].relative,
            **known,
        )
        vars(estimate)["_each"] = tuple(each)
        return estimate

    @classmethod
    def later(cls, rest: Mapping[str, Callable[[], Any]], **known: Any) -> "Estimate":
        """Estimate of which some attributes are computed when they are first asked for.

        Parameters
        ----------
        rest : mapping of names to functions without arguments
            Whatever has no default and is not known, and nothing that has one, each computed at
            most once, by any thread.
        known
            The other attributes.
        """
        missing = REQUIRED - rest.keys() - known.keys()
        unknown = (rest.keys() | known.keys()) - cls.__dataclass_fields__.keys()
        if missing or unknown:
            raise TypeError(f"missing {sorted(missing)}, unknown {sorted(unknown)}")
        later = dict(rest)
        if "contacts" in known:  # which become `Contacts` when they are looked at
            contacts = known.pop("contacts")
            later["contacts"] = lambda: contacts
        estimate = object.__new__(cls)
        vars(estimate).update(known, _rest=later, _lock=RLock())
        return estimate

    if not TYPE_CHECKING:  # a type checker should still tell names that do not exist

        def __getattr__(self, name: str) -> Any:
            own = vars(self)
            rest = own.get("_rest", {})
            with own.get("_lock", nullcontext()):
                if name in rest:
                    value = rest[name]()
                    own[name] = Contacts.of(self, value) if name == "contacts" else value
                    del rest[name]  # with what it held on to
                elif name not in own:  # where it is, another thread was faster
                    raise AttributeError(f"{type(self).__name__} has no attribute {name!r}")
                return own[name]

    def __dir__(self) -> list[str]:
        """Names of all results, computed or not yet."""
        return sorted({*super().__dir__(), *self.__dataclass_fields__})

    def __getstate__(self) -> dict[str, Any]:
        """All attributes, computed: another process cannot compute them."""
        return {name: getattr(self, name) for name in self.__dataclass_fields__}

    def __setstate__(self, state: dict[str, Any]) -> None:
        vars(self).update(state)

    def __repr__(self) -> str:
        if self.is_batch:
            highest = number(float(np.max(self.normal_force, initial=0.0)))
            what = f"{plural(len(self), 'reading')}, up to {highest}"
        else:
            count = plural(len(self.contacts), "contact")
            what = f"{count}, {number(float(self.normal_force))}"
        unit, (rows, columns) = " (relative)" if self.relative else " N", self.grid.shape
        return f"Estimate({self.grid.patch.name!r}, {what}{unit}, {columns} x {rows} nodes)"

    def plot(
        self, ax: Place = None, *, truth: Iterable[tuple[Any, Any, float]] | None = None
    ) -> Any:
        """Draw the pressure over the patch, its taxels and contacts; of a run, force over time.

        Each contact has its outline and its normal force ± one standard deviation.

        Parameters
        ----------
        ax : matplotlib Axes, optional
            To draw in. Default those of a new figure.
        truth : sequence of (position, force, radius), optional
            What was truly pressed: position (3,) m, or (2,) m in the patch's plane; force in N;
            radius in m. Of one reading only.

        Returns
        -------
        matplotlib Axes
            Lengths in mm and pressure in kPa, or time in s and force in N.

        Raises
        ------
        InputError
            For a truth that is none, if `ax` is something else, or Matplotlib is not installed.

        See Also
        --------
        skinfield.estimate.plot.draw_estimate : readings, deformation and a table beside it
        """
        return drawing("skinfield.estimate.plot:plot_estimate")(self, ax, truth)

    def _facts(self) -> Mapping[str, str]:
        unit = "(relative)" if self.relative else "N"
        solvers = dict.fromkeys((self.solver,) if isinstance(self.solver, str) else self.solver)
        rows, columns = self.grid.shape
        facts = {"Estimate": self.grid.patch.name}
        if self.is_batch:
            span = (np.ravel(self.stamp_ns)[-1] - np.ravel(self.stamp_ns)[0]) * 1e-9
            highest = number(float(np.max(self.normal_force, initial=0.0)))
            facts |= {"readings": str(len(self)), "length": f"{number(float(span))} s"}
            facts |= {"highest force": f"{highest} {unit}"}
        else:
            facts |= {f"contact {n + 1}": _line(c, unit) for n, c in enumerate(self.contacts)}
            facts |= {"force": f"{number(float(self.normal_force))} {unit}"}
            facts |= {"taxels used": f"{int(self.valid.sum())} of {len(self.valid)}"}
        return {
            **facts,
            "grid": f"{columns} × {rows} nodes of {number(self.grid.pitch * 1e3)} mm",
            "solver": ", ".join(solvers),
            **({"notes": "; ".join(self.notes)} if self.notes else {}),
        }

    @property
    def is_batch(self) -> bool:
        """Whether a leading axis of readings is there."""
        return self.pressure.ndim == 2

    @property
    def force(self) -> Floats:
        """Force on each cell, ([T,] K, 3) N: traction times the cell's area."""
        return np.asarray(self.traction * self.grid.cell_area)

    @property
    def normal_force(self) -> Any:
        """Sum of the contacts', N, or of the field's where that is the answer; (T,) for a batch."""
        return self._field_force if np.all(self.is_field) else self.contacts.normal_force

    @property
    def _field_force(self) -> Any:
        return self.pressure.sum(axis=-1) * self.grid.cell_area

    @property
    def wrenches(self) -> dict[str, Wrench]:
        """Wrench of its contacts about the origin of the patch's link, by the link's name.

        Raises InputError for an estimate of several readings: take those of ``estimate[i]``.
        """
        if self.is_batch:
            raise InputError(
                f"wrenches are of one reading, and this estimate is of {len(self)}, expected one: "
                "take those of estimate[i]"
            )
        patch = self.grid.patch
        wrench = Wrench.of(self.contacts, patch.link_from_patch, int(self.stamp_ns))
        return {patch.link: wrench}

    @property
    def indentation(self) -> Floats:
        """Displacement into the skin along its normal, ([T,] K) m, positive inwards."""
        inwards = -np.einsum("...kc,kc->...k", self.displacement, self.grid.normals)
        return np.asarray(inwards, dtype=np.float64)

    def __len__(self) -> int:
        if not self.is_batch:
            raise InputError("an estimate of one reading has no length: index est.contacts instead")
        return len(self.pressure)

    def __getitem__(self, index: int) -> "Estimate":
        if not self.is_batch:
            raise InputError(
                "an estimate of one reading cannot be indexed: it is the reading's own"
            )
        each: tuple[Estimate, ...] | None = vars(self).get("_each")
        if each is not None:
            return each[index]
        share = self.pressure[index].size / self.pressure.size
        fields = {name: getattr(self, name)[index] for name in REQUIRED - {"grid"}}
        for name in ("stamp_ns", "gap", "iterations", "deadline_met", "is_field"):
            fields[name] = np.broadcast_to(getattr(self, name), len(self))[index]
        solver = self.solver[index] if isinstance(self.solver, tuple) else self.solver
        return replace(self, latency=self.latency * share, solver=solver, **fields)

    def __iter__(self) -> Iterator["Estimate"]:
        return (self[index] for index in range(len(self)))


def _line(contact: Contact, unit: str) -> str:
    """A contact in a line."""
    place, force, area = contact._words()
    return f"{force} {unit} at ({place}) mm, {area} mm²"


REQUIRED = {"grid", "pressure", "traction", "displacement", "pressure_std", "contacts"}
REQUIRED |= {"residual", "valid", "readings", "readings_std"}  # what no estimate is without
