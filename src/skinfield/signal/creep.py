"""Creep compensation: readings of a skin whose elastomer creeps, as of one that does not; compiled.

Displacements are linear in the pressure that makes them, its history included, and a taxel reads
them linearly as a strain. So what each taxel reads is run backwards by itself, whatever touches
how, for how long and with what area: of the strain

    u = φ p + (1 - φ) z,    τ' dz/dt = p - z,    φ = E∞ / E₀,    τ' = τ / φ,

p is the elastic one of now's pressure, and z what lags behind it. A straight line from the p before
to that of now moves z by known parts of both, at any spacing, so that each reading gives its p: the
inverse of `StandardLinearSolid.effective_force`, reading after reading.

The strain c / (1 + c) of a gap that is not even over the pad is more than the mean one, up to twice
below a ball, and never less (Jensen's inequality). So what is left of a press is less than by this
strain: it is taken off down to nothing, and not beyond.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from skinfield.compiled import inner, njit
from skinfield.elastic import Capacitance, Quantity, StandardLinearSolid
from skinfield.elastic.observation import STEEPEST
from skinfield.errors import Floats, Ints, check_shape
from skinfield.signal.drift import BACK_NS

LINEAR, STRAIN = 0, 1  # what is linear in displacements: readings as they are, or c / (1 + c)
NS = 1e-9
Flags = NDArray[np.bool_]


@inner
def lag_weights(part: float) -> tuple[float, float]:
    """What is kept of a lag, and the weight of the newest value, after a part of its time.

    The value before has the rest; see `elastic.viscoelastic.lagged`.
    """
    kept = np.exp(-part)
    return kept, 1.0 + np.expm1(-part) / part if part > 0.0 else 0.0


@njit
def undo_creep(
    values: Floats,
    valid: Flags,
    arrived: Ints,
    stamps: Ints,
    starts: Ints,
    solids: tuple[Floats, Floats],
    how: int,
    standing: bool,
    state: tuple[Floats, Floats, Floats, Ints],
) -> None:
    """Replace readings (L,) by those without creep.

    Parameters
    ----------
    values : (L,) array
        In the quantity's unit, of the taxels of all patches.
    valid : (L,) bool array
        Taxels that answered; of others, and of NaN, nothing changes.
    arrived, stamps : (P,) arrays
        Whether a patch has a new reading, 0 if not: then its last results are written once more;
        and when it was made, ns. Without a stamp, 0, a reading is left as it is.
    starts : (P + 1,) array
        Where each patch's taxels begin.
    solids : pair of (P,) arrays
        Relaxed fractions and time constants, s, of their elastomers; 1 where it does not creep.
    how : int
        `LINEAR` or `STRAIN`.
    standing : bool
        Whether what a taxel reads first has stood for long; else it rested until then.
    state : tuple of arrays
        Of each taxel its lagged strain, its elastic strain, its result, and when that was; 0 of one
        that has not answered yet.
    """
    lagged, elastic, result, at = state
    for patch in range(len(stamps)):
        fraction, stamp = solids[0][patch], stamps[patch]
        time_constant = solids[1][patch] / fraction
        if fraction == 1.0 or stamp == 0:
            continue
        since, kept, newest = np.int64(-1), 1.0, 0.0
        for taxel in range(starts[patch], starts[patch + 1]):
            if not valid[taxel] or np.isnan(values[taxel]):
                continue
            if arrived[patch] == 0:
                values[taxel] = result[taxel] if at[taxel] != 0 else values[taxel]
                continue
            strain = values[taxel]
            if how == STRAIN:
                strain /= 1.0 + strain
            if at[taxel] == 0 or stamp < at[taxel] - BACK_NS:
                lagged[taxel] = elastic[taxel] = strain if standing else 0.0
                at[taxel] = stamp
            passed = max(stamp - at[taxel], 0)
            if passed != since:
                since = passed
                kept, newest = lag_weights(NS * passed / time_constant)
            late = kept * lagged[taxel] + (1.0 - kept - newest) * elastic[taxel]
            left = (1.0 - fraction) * late
            if how == STRAIN and left > max(strain, 0.0):
                left = max(strain, 0.0)
            strain = (strain - left) / (fraction + (1.0 - fraction) * newest)
            lagged[taxel], elastic[taxel] = late + newest * strain, strain
            at[taxel] = max(at[taxel], stamp)
            if how == STRAIN:
                strain = min(strain, STEEPEST)
                strain /= 1.0 - strain
            values[taxel] = result[taxel] = strain


class CreepCompensation:
    """What the taxels of some patches remember of what pressed them, and how it is taken off.

    Parameters
    ----------
    solids : sequence of StandardLinearSolid or None
        Elastomer of each patch; None of one that does not creep.
    starts : (P + 1,) array
        Where each patch's taxels begin.
    quantity : Quantity
        What a reading is.
    standing : bool
        Whether what is read first has stood for long, as when a live skin is begun anew under a
        hand; else the skin rested until then.

    Attributes
    ----------
    active : bool
        Whether any of them creeps; else `take` changes nothing.
    noise_factor : (L,) array
        Standard deviation of a result over that of a reading: 1 / φ, of a noise that is white; of
        readings that are further apart than the time constant it is less.
    """

    def __init__(
        self,
        solids: Sequence[StandardLinearSolid | None],
        starts: Ints,
        quantity: Quantity,
        *,
        standing: bool = False,
    ) -> None:
        check_shape("starts", starts, (len(solids) + 1,), "where each patch begins, and the end")
        fractions = np.array([1.0 if each is None else each.relaxed_fraction for each in solids])
        times = np.array([1.0 if each is None else each.time_constant for each in solids])
        self._solids, self._starts, self._standing = (fractions, times), starts, standing
        self.active = bool((fractions < 1.0).any())
        self.noise_factor: Floats = np.repeat(1.0 / fractions, np.diff(starts))
        strains = isinstance(quantity, Capacitance) and quantity.order != 1
        self._how = STRAIN if strains else LINEAR
        rows = np.zeros((4, len(self.noise_factor)))
        self._state = rows[0], rows[1], rows[2], np.zeros(rows.shape[1], np.int64)
        self._one: Floats = rows[3]
        self._every = np.ones(rows.shape[1], np.bool_)
        self._new, self._stamp = np.ones(1, np.int64), np.zeros(1, np.int64)
        if self.active:  # load what is compiled
            once = np.ones(len(solids), np.int64)
            self.take(self._one, self._every, once, once)
            self.reset()

    @classmethod
    def of(
        cls, solid: StandardLinearSolid | None, taxels: int, quantity: Quantity
    ) -> "CreepCompensation":
        """Of one patch, whose skin rested before its first reading."""
        return cls([solid], np.array([0, taxels]), quantity)

    def take(self, values: Floats, valid: Flags, arrived: Ints, stamps_ns: Ints) -> None:
        """Replace readings (L,) by those without creep, in place; see `undo_creep`."""
        if self.active:
            how = self._solids, self._how, self._standing, self._state
            undo_creep(values, valid, arrived, stamps_ns, self._starts, *how)

    def taken(self, table: Floats, valid: Flags, stamps_ns: Ints) -> Floats:
        """Readings (T, L) of one patch one after the other, without creep; a copy if any."""
        if not self.active:
            return table
        out = table.copy()
        for row, its, stamp in zip(out, valid, stamps_ns, strict=True):
            self._stamp[0] = stamp
            self.take(row, its, self._new, self._stamp)
        return out

    def next_of(self, reading: Floats, stamp_ns: int) -> Floats:
        """Reading (L,) of all taxels of one patch without creep, in memory that is used again."""
        self._one[:], self._stamp[0] = reading, stamp_ns
        self.take(self._one, self._every, self._new, self._stamp)
        return self._one

    def go_on_from(self, lagged: Floats, stamp_ns: int) -> None:
        """Begin with strains (L,) that lag behind, at a time, from when nothing presses."""
        self.reset()
        self._state[0][:], self._state[3][:] = lagged, stamp_ns

    def reset(self) -> None:
        """Forget all readings."""
        for each in self._state:
            each[:] = 0
