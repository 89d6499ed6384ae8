"""Estimate of a patch: fields and contacts of one reading, or of a run of them."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import nullcontext
from dataclasses import dataclass, field, replace
from functools import partial
from threading import RLock
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import Floats, InputError
from skinfield.skin import Grid


@dataclass(frozen=True, eq=False)
class Estimate:
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
    contacts : tuple of Contact, or of T such tuples
        In order of falling force.
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
        estimate = object.__new__(cls)
        vars(estimate).update(known, _rest=dict(rest), _lock=RLock())
        return estimate

    if not TYPE_CHECKING:  # a type checker should still tell names that do not exist

        def __getattr__(self, name: str) -> Any:
            own = vars(self)
            rest = own.get("_rest", {})
            with own.get("_lock", nullcontext()):
                if name in rest:
                    own[name] = rest[name]()
                    del rest[name]  # with what it held on to
                elif name not in own:  # where it is, another thread was faster
                    raise AttributeError(f"{type(self).__name__} has no attribute {name!r}")
                return own[name]

    def __getstate__(self) -> dict[str, Any]:
        """All attributes, computed: another process cannot compute them."""
        return {name: getattr(self, name) for name in self.__dataclass_fields__}

    def __setstate__(self, state: dict[str, Any]) -> None:
        vars(self).update(state)

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
        force = self.pressure.sum(axis=-1) * self.grid.cell_area
        if np.all(self.is_field):
            return force
        each = self.contacts if self.is_batch else (self.contacts,)
        sums = np.array([sum((c.normal_force for c in found), 0.0) for found in each])
        return np.where(self.is_field, force, sums) if self.is_batch else sums[0]

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


REQUIRED = {"grid", "pressure", "traction", "displacement", "pressure_std", "contacts"}
REQUIRED |= {"residual", "valid", "readings", "readings_std"}  # what no estimate is without
