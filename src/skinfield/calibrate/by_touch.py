r"""Calibration by touches of which nothing is known: layer, cover, gains of taxels, noise.

Some hundred presses of anything, anywhere, say what the skin is like, as each is read by several
taxels: a joint fit of the presses and of what they share (see `touch_fit`). What they cannot tell
is the scale of force: the modulus times a gain that all taxels have in common. So forces remain
relative until one of them is known.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from skinfield.calibrate.press_tables import PressTables
from skinfield.calibrate.touch_fit import (
    ALONE,
    OWN,
    Data,
    JointFit,
    Priors,
    State,
    readings,
    refined,
    start,
)
from skinfield.calibrate.touch_presses import STRONG, Presses, between, presses
from skinfield.calibrate.touch_relaxation import Relaxation, relaxation, traces
from skinfield.calibrate.touch_sampling import marginal
from skinfield.elastic import BondedLayer, Capacitance, Layer, Quantity, StandardLinearSolid
from skinfield.errors import (
    Floats,
    InputError,
    as_floats,
    as_stamps,
    check_finite,
    check_range,
    check_shape,
    check_type,
)
from skinfield.signal import Calibration
from skinfield.skin import Patch

LEAST, USUAL, BALLS = 20, 100, 12  # presses, what is usual, and those that a ball explains
SILENT = 4.0  # deviations of a reading: a taxel that never reads more is dead, if it should
FREEDOM = 4.0  # deviations of chi-squared, beyond which a press is no ball: it is left out
SLACK = 1.5  # times the median press's chi-squared, above which it may be left out
ERRORS = (0.1, 0.03, 0.1, 0.05, 0.02, 0.01, 0.004)  # parts of what is read
FIRST = 2  # of these, by which the fit begins
AGAIN = 2  # times with the nodes of the tables, weights and priors that were found
BETWEEN_NODES = np.array([0.003, 0.0005])  # of ln thickness and ratio: what tables are off by
WIDER = 2.3  # times the deviations of the likelihood: chosen on virtual skins
# Where places are not exact: bodies are no balls, and boards creep and drift. By ten real skins.
AS_MADE, GAINS_AS_MADE = np.array([0.15, 0.05]), 1.3  # of ln thickness and ratio; times the gains'
DOUBT = 1.0 / 3.0  # part of the presses left out, from which on the rest tells little
MOST_READ = 3.0  # of ΔC/C₀ where a press is read most: a quarter of the gap is left
RATIO = 0.46  # Poisson's, at which it begins at most: what is stated for rubber is its limit
NO_FORCE = (
    "known_force knows no force of a touch that is explained by a ball, expected one above 0 N or "
    "more: see that it is known when the touch is read"
)


@dataclass(frozen=True, eq=False)
class TouchCalibration:
    """What touches say of a skin.

    Attributes
    ----------
    thickness, thickness_std : float, m
    poisson_ratio, poisson_std : float
    young_modulus : float, Pa
        Assumed, unless forces were known.
    covered : bool
        Whether an inextensible cover lies on the layer.
    gain, gain_std : (L,) arrays
        Of each taxel beside the others: their geometric mean is 1.
    noise_std : (L,) array, in the quantity's unit
        Of readings divided by the gains.
    model_error : float
        Part of what taxels read, by which the model is wrong.
    presses, left_out : int
        Of which it was made, and which no ball explains.
    force_ratio : float
        Known forces over assumed ones; NaN where no force was known.
    counts : Calibration, optional
        From counts to readings, these gains included; without it readings are taken.
    relaxed_fraction, relaxed_fraction_std : float, optional
        E∞ / E₀ of the elastomer. None: touches do not tell that it creeps.
    relaxation_time, relaxation_time_std : float, s, optional
        Time constant of that.
    """

    thickness: float
    thickness_std: float
    poisson_ratio: float
    poisson_std: float
    young_modulus: float
    covered: bool
    gain: Floats
    gain_std: Floats
    noise_std: Floats
    model_error: float
    presses: int
    left_out: int
    force_ratio: float
    counts: Calibration | None = None
    relaxed_fraction: float | None = None
    relaxed_fraction_std: float | None = None
    relaxation_time: float | None = None
    relaxation_time_std: float | None = None

    def __post_init__(self) -> None:
        for name in ("gain_std", "noise_std"):
            check_shape(name, getattr(self, name), self.gain.shape, "one per taxel")
        if self.gain.ndim != 1 or not (self.gain > 0.0).all():
            raise InputError("gain holds what is not above 0, expected one above 0 per taxel")
        stds = self.relaxed_fraction_std, self.relaxation_time_std
        creep = [self.relaxed_fraction, self.relaxation_time, *stds]
        if 0 < creep.count(None) < len(creep):
            raise InputError(
                f"relaxed_fraction and relaxation_time with their deviations are {creep}, expected "
                "four numbers, or four times None"
            )
        self.relaxation  # noqa: B018 - refuses what no solid has

    def __len__(self) -> int:
        return len(self.gain)

    @property
    def layer(self) -> Layer:
        """The elastomer."""
        how = self.thickness, self.young_modulus, self.poisson_ratio
        return Layer(*how, relaxation=self.relaxation)

    @property
    def relaxation(self) -> StandardLinearSolid | None:
        """How it creeps; None where touches do not tell that it does."""
        if self.relaxed_fraction is None or self.relaxation_time is None:
            return None
        return StandardLinearSolid(self.relaxed_fraction, self.relaxation_time)

    @property
    def mechanics(self) -> BondedLayer:
        """How it deforms."""
        return BondedLayer(inextensible_cover=self.covered)

    @property
    def relative(self) -> bool:
        """Whether forces are in units of their own: no known one was among the touches."""
        return bool(np.isnan(self.force_ratio))

    @property
    def verdict(self) -> str:
        """What was found, in a sentence."""
        spread = float(np.std(np.log(self.gain)))
        scale = (
            f"forces are relative: they go with the modulus, assumed {self.young_modulus * 1e-3:g} "
            "kPa, until one is known"
            if self.relative
            else f"modulus {self.young_modulus * 1e-3:.4g} kPa"
        )
        doubt = (
            "; doubtful: a third of the presses or more is explained by no ball, press with "
            "something round"
            if self.left_out >= DOUBT * (self.presses + self.left_out)
            else ""
        )
        return (
            f"thickness {self.thickness * 1e3:.3f} ± {self.thickness_std * 1e3:.3f} mm, Poisson's "
            f"ratio {self.poisson_ratio:.4f} ± {self.poisson_std:.4f}, "
            f"{'under a cover' if self.covered else 'no cover'}; {self._creep}"
            f"gains spread by {spread:.1%}, each known to {float(np.median(self.gain_std)):.1%}; "
            f"model error {self.model_error:.1%}; "
            f"{self.presses} presses, {self.left_out} left out; {scale}{doubt}"
        )

    @property
    def _creep(self) -> str:
        solid, stds = self.relaxation, (self.relaxed_fraction_std, self.relaxation_time_std)
        if solid is None or None in stds:
            return ""
        return (
            f"creeps by {1.0 - solid.relaxed_fraction:.1%} ± {stds[0]:.1%} within "
            f"{solid.time_constant:.3g} ± {stds[1]:.2g} s; "
        )

    def __repr__(self) -> str:
        return f"TouchCalibration({self.verdict})"

    def readings(self, values: ArrayLike) -> Floats:
        """What a `Reconstructor` takes of counts, or of readings, (L,) or (T, L)."""
        if self.counts is not None:
            return self.counts.relative_capacitance_from_counts(values)
        return np.asarray(as_floats("values", values) / self.gain)

    def of_taxels(self, patch: Patch) -> Calibration:
        """From counts to readings; without counts, from readings as those of the touches."""
        if self.counts is not None:
            return self.counts
        noise = self.noise_std * self.gain
        whole = self.with_counts(Calibration.identity(patch, noise_std=noise)).counts
        assert whole is not None  # just made
        return whole

    def with_counts(self, counts: Calibration) -> "TouchCalibration":
        """The same for counts, which a calibration turned into the readings of the touches."""
        own = replace(counts, gain=counts.gain * self.gain, basis=f"{counts.basis}; touches")
        return replace(self, counts=own)


def touch(
    patch: Patch,
    readings: ArrayLike,
    *,
    quantity: Quantity | None = None,
    noise_std: ArrayLike | None = None,
    layer: Layer | None = None,
    known_force: ArrayLike | None = None,
    place_std: float = 0.0,
    stamp_ns: ArrayLike | None = None,
) -> TouchCalibration:
    """Calibrate a skin by touches of which nothing is known.

    Parameters
    ----------
    patch : Patch
        Of L taxels.
    readings : (T, L) array, in the quantity's unit
        Of balls, fingertips or the like, one at a time, all over the patch; what is read between
        them is taken off. NaN where a taxel did not answer.
    quantity : Quantity, optional
        What a reading is. Default `Capacitance()`.
    noise_std : float or (L,) array, optional
        Of one reading. Default as readings that follow each other differ.
    layer : Layer, optional
        About what is expected, of which the modulus is taken. Default `Layer()`.
    known_force : (T,) array, N, optional
        NaN of readings whose force is not known. One is enough for newtons.
    place_std : float, m
        How far taxels are from their stated places along each axis; 0.3 mm is usual where a skin is
        made by hand. The default, 0, is a simulation's: then stated deviations are of balls and a
        model that holds, else of bodies and boards as they are, too.
    stamp_ns : (T,) array, ns, optional
        Of the readings, which may fall from one recording to the next: by them, what is read where
        touches have been tells how the elastomer creeps.

    Raises
    ------
    InputError
        If there are too few touches, readings fall under them or do not tell their noise, or
        arguments do not go together or are of another unit.
    """
    quantity, nominal = quantity or Capacitance(), layer or Layer()
    check_type("quantity", quantity, Quantity, "such as skinfield.elastic.Capacitance()")
    why = "in metres, how far taxels are from their places: 0.3e-3 is usual"
    check_range("place_std", place_std, 0.0, patch.pitch, why)
    table = as_floats("readings", readings)
    found = checked_presses(table, patch, quantity, noise_std, LEAST, USUAL)
    known = _known_forces(known_force, found.row)
    values, heard = np.nan_to_num(found.readings), np.isfinite(found.readings)
    silent = (values < SILENT * found.noise).all(axis=0)
    data = Data(
        values,
        heard & ~silent,
        found.noise,
        found.clipped,
        patch.plane,
        quantity,
        place_std,
    )
    first = [
        _fitted(data, patch, nominal, quantity, covered, ERRORS[: FIRST + 1])
        for covered in (False, True)
    ]
    common = first[0].used & first[1].used
    covered = bool(first[1].on(common) > first[0].on(common))
    dead = silent & (first[covered].reads().max(axis=0) > STRONG * found.noise_std)
    data = replace(data, heard=heard & ~dead)
    fit = _fitted(data, patch, nominal, quantity, covered, ERRORS)
    made, forces = fit.finished(nominal, found.noise_std)
    if stamp_ns is not None:
        stamps = as_stamps("stamp_ns", stamp_ns)
        check_shape("stamp_ns", stamps, (len(table),), "one per reading")
        made = fit.with_creep(made, table, stamps, found.row)
    return made if known is None else _scaled(made, known, forces, found)


def _known_forces(known_force: ArrayLike | None, row: NDArray[np.int64]) -> Floats | None:
    """Known forces (T,) of readings, the rows (T,) of whose presses are -1 of none; checked."""
    if known_force is None:
        return None
    known = as_floats("known_force", known_force)
    check_shape("known_force", known, row.shape, "one per reading, NaN where not known")
    if not (known > 0.0).any() or np.isinf(known).any():
        held = known[~np.isnan(known)]
        holds = f"{held.min():g} to {held.max():g} N" if len(held) else "nothing but NaN"
        raise InputError(f"known_force holds {holds}, expected a force above 0 N or more of them")
    if not (known[row >= 0] > 0.0).any():
        raise InputError(NO_FORCE)
    return known


def checked_presses(
    table: Floats,
    patch: Patch,
    quantity: Quantity,
    noise_std: ArrayLike | None,
    least: int,
    usual: int,
) -> Presses:
    """Presses in readings (T, L), `least` or more and better `usual`; see `touch`."""
    check_shape("readings", table, (None, len(patch)), "readings and taxels of the patch")
    check_finite("readings", np.nan_to_num(table, posinf=np.inf, neginf=-np.inf), "or NaN")
    noise = None
    if not len(table):
        raise InputError("readings are none, expected some of touches")
    if noise_std is not None:
        noise = as_floats("noise_std", noise_std)
        if noise.ndim:
            check_shape("noise_std", noise, (len(patch),), "one of all, or one per taxel")
        noise = np.broadcast_to(noise, (len(patch),)).copy()
        if not (np.isfinite(noise) & (noise > 0.0)).all():
            raise InputError(f"noise_std is {noise.min()}, expected above 0: no reading is exact")
    found = presses(table, noise)
    if len(found.readings) < least:
        raise InputError(
            f"readings hold {len(found.readings)} touches above {STRONG:g} times the noise "
            f"({np.median(found.noise_std):.2g}), expected {least} or more, better {usual}, all "
            f"over the patch: add {least - len(found.readings)} or more; if their noise is "
            "another, state it (noise_std=, --noise)"
        )
    highest = float(np.percentile(np.nanmax(found.readings, axis=1), 90.0))
    if isinstance(quantity, Capacitance) and highest > MOST_READ:
        raise InputError(
            f"readings are {highest:.3g} where strong presses are read most, expected some 0.05 to "
            "1 of ΔC/C₀: divide percent by 100, and counts by their gain (gain=, --gain)"
        )
    return found


def _scaled(
    made: TouchCalibration, known: Floats, forces: Floats, found: Presses
) -> TouchCalibration:
    """The same with the modulus that known forces (T,) of readings give."""
    ratios = (known / forces[found.row])[found.row >= 0]
    ratios = ratios[np.isfinite(ratios) & (ratios > 0.0)]
    if not len(ratios):
        raise InputError(NO_FORCE)
    ratio = float(np.exp(np.median(np.log(ratios))))
    return replace(made, young_modulus=made.young_modulus * ratio, force_ratio=ratio)


@dataclass(frozen=True, eq=False)
class _SkinFit:
    """A fit under a cover or without; `evidence` is that of a press."""

    fit: JointFit
    state: State
    used: NDArray[np.bool_]
    evidence: float
    covered: bool

    def reads(self) -> Floats:
        """What taxels (T, L) of gain 1 read by it, of the presses that are used."""
        taxels = self.fit.data.taxels
        return readings(self.fit.tables, self.state.touches, self.state.skin, taxels)

    def on(self, presses: NDArray[np.bool_]) -> float:
        """Evidence on some of the presses that are used."""
        rows = presses[self.used]
        state = replace(self.state, touches=self.state.touches[rows])
        fit = JointFit(self.fit.data.only(rows), self.fit.tables, self.fit.priors, self.fit.error)
        return fit.normal(fit.run(state)).evidence

    def with_creep(
        self,
        made: TouchCalibration,
        table: Floats,
        stamps: NDArray[np.int64],
        row: NDArray[np.int64],
    ) -> TouchCalibration:
        """Calibration with the relaxation that readings (T, L) tell after touches, if they do."""
        touches = np.full((len(self.used), OWN), np.nan)
        touches[self.used] = self.state.touches
        places = self.fit.tables, self.fit.data.taxels
        noise = made.noise_std * made.gain
        known = touches, self.state.skin, made.gain, noise, places
        above = table - between(table, noise)
        found: Relaxation | None = relaxation(traces(above, stamps, row, *known))
        if found is None:
            return made
        return replace(
            made,
            relaxed_fraction=found.solid.relaxed_fraction,
            relaxed_fraction_std=found.share_std,
            relaxation_time=found.solid.time_constant,
            relaxation_time_std=found.time_std,
        )

    def finished(self, nominal: Layer, noise: Floats) -> tuple[TouchCalibration, Floats]:
        """Calibration, and forces (T,), N; NaN of presses that are left out."""
        state, covariance = marginal(self.fit, self.state)
        deviation = np.sqrt(np.diag(covariance))
        inexact = self.fit.data.place_std > 0.0
        deviation[:2] = np.hypot(WIDER * deviation[:2], AS_MADE if inexact else BETWEEN_NODES)
        deviation[2:] *= GAINS_AS_MADE if inexact else 1.0
        gain, thickness = np.exp(state.log_gain), float(np.exp(state.skin[0]))
        forces = np.full(len(self.used), np.nan)
        forces[self.used] = np.exp(state.touches[:, 2])
        made = TouchCalibration(
            thickness=thickness,
            thickness_std=thickness * float(deviation[0]),
            poisson_ratio=float(state.skin[1]),
            poisson_std=float(deviation[1]),
            young_modulus=nominal.young_modulus,
            covered=self.covered,
            gain=gain,
            gain_std=gain * deviation[2:],
            noise_std=noise / gain,
            model_error=self.fit.error,
            presses=int(self.used.sum()),
            left_out=int((~self.used).sum()),
            force_ratio=float("nan"),
        )
        return made, forces


def _fitted(
    data: Data,
    patch: Patch,
    nominal: Layer,
    quantity: Quantity,
    covered: bool,
    errors: tuple[float, ...],
) -> _SkinFit:
    """Fit of presses and skin, under a cover or without."""
    tables = PressTables(nominal, quantity, patch.pad_diameter, covered)
    skin = np.array([np.log(nominal.thickness), min(nominal.poisson_ratio, RATIO)])
    tables.centre_on(*skin)
    state = State(np.zeros((len(data.readings), OWN)), skin, np.zeros(len(data.taxels)))
    state = replace(state, touches=start(data, tables, state, errors[0]))
    priors = Priors.wide(skin, state.touches, data)
    whole, used = state, np.ones(len(data.readings), np.bool_)
    best: _SkinFit | None = None
    for place, error in enumerate(errors):
        fit = JointFit(data.only(used), tables, priors, error)
        for _ in range(AGAIN):
            tables.centre_on(*state.skin)
            state = fit.run(state)
            fit.learn(state)
        priors, normal = fit.priors, fit.normal(state)
        touches = whole.touches.copy()
        touches[used] = state.touches
        whole = replace(state, touches=touches)
        if place >= FIRST:
            evidence = normal.evidence / int(used.sum())
            if best is None or evidence > best.evidence:
                best = _SkinFit(fit, state, used, evidence, covered)
            continue
        whole = _begun_again(data, tables, whole, priors, error)
        used = _balls(JointFit(data, tables, priors, error), whole)
        state = replace(whole, touches=whole.touches[used])
    assert best is not None
    return best


def _begun_again(
    data: Data, tables: PressTables, state: State, priors: Priors, error: float
) -> State:
    """Presses from new starts, where these lead further down."""
    afresh = replace(state, touches=start(data, tables, state, error))
    weight = data.weight(error)
    return refined(data, tables, [state, afresh], weight, priors, ALONE)


def _balls(fit: JointFit, state: State) -> NDArray[np.bool_]:
    """Presses (T,) that a ball explains.

    Before gains are known that is a quarter of them less, on any skin unlike its model.
    """
    fit.aim(state)
    squares, count = fit.misfit(state).sum(axis=1), fit.data.heard.sum(axis=1)
    most = count + FREEDOM * np.sqrt(2.0 * count)
    fine = squares <= np.maximum(most, SLACK * np.median(squares))
    if fine.sum() < BALLS:
        more = int(np.ceil((BALLS - fine.sum()) / max(fine.mean(), 0.1)))
        raise InputError(
            f"{fine.sum()} of {len(fine)} touches are as a ball makes them, expected {BALLS} or "
            f"more: add {more} or more, with something round, one place at a time"
        )
    return np.asarray(fine)
