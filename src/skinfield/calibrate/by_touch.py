r"""Calibration by presses of anything: place, size and force of all of them unknown.

Where a press is felt, and how far, tells the thickness of the layer, its Poisson's ratio and
whether a cover lies on it; that many presses must agree tells the taxels' gains (`touch_fit`).
What they cannot tell is the scale: all forces, the modulus and a common gain may be multiplied. So
gains have a geometric mean of 1, and the modulus is the nominal one until some force is known.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from skinfield.calibrate.press_tables import NARROW, PressTables
from skinfield.calibrate.touch_fit import (
    OWN,
    Data,
    JointFit,
    Normal,
    Priors,
    State,
    read,
    refined,
    start,
)
from skinfield.elastic import BondedLayer, Capacitance, Layer, Quantity, check_skin
from skinfield.errors import Floats, InputError, as_floats, check_shape
from skinfield.reconstruct.reconstructor import checked_readings
from skinfield.signal.noise import TOUCHED, shared_noise, usual_deviation
from skinfield.skin import Patch

LEAST = 20  # presses
IDLE = 20  # readings, from which on they alone tell the noise
SOME, MOST = 60, 400  # presses that choose the cover, and that are fitted at last
LOUD = 12.0  # times the noise, that a press is read with by one taxel at least
RATIO = 0.47  # Poisson's, where the search begins: at 0.5 there is one way to go
FIRST_ERROR, NEXT_ERROR = 0.1, 0.03  # of the model, to begin with: of some presses, of all
ERRORS = np.geomspace(1e-3, 0.3, 40)  # of the model
FAR = 3.0  # times the usual misfit, beyond which a press is none of one ball
STAGES = 4
SLOWLY = 0.3  # of the model error, to which it falls at most from stage to stage
FORCE_ERROR = 0.01  # of a force that a press is known by


@dataclass(frozen=True, eq=False)
class TouchCalibration:
    """A skin as its presses tell it.

    Attributes
    ----------
    thickness, thickness_std : float, m
    poisson_ratio, poisson_ratio_std : float
    young_modulus, young_modulus_std : float, Pa
        The nominal one, and NaN, while `relative`.
    relative_permittivity : float
        The nominal one.
    covered : bool
        Whether an inextensible cover lies on the layer.
    gain, gain_std : (L,) array
        By which a taxel reads more than the model says, geometric mean 1.
    noise_std : (L,) array
        Of one reading over its gain, in the quantity's unit.
    model_error : float
        Part of a reading by which the model is wrong.
    presses, left_out : int
        Fitted, and those that are none of one ball.
    relative : bool
        Whether forces are known up to a common factor only.
    """

    thickness: float
    thickness_std: float
    poisson_ratio: float
    poisson_ratio_std: float
    young_modulus: float
    young_modulus_std: float
    relative_permittivity: float
    covered: bool
    gain: Floats
    gain_std: Floats
    noise_std: Floats
    model_error: float
    presses: int
    left_out: int
    relative: bool

    def __post_init__(self) -> None:
        for name in ("gain_std", "noise_std"):
            check_shape(name, getattr(self, name), (len(self.gain),), "one per taxel")

    def __len__(self) -> int:
        return len(self.gain)

    @property
    def layer(self) -> Layer:
        """The layer."""
        return Layer(
            self.thickness, self.young_modulus, self.poisson_ratio, self.relative_permittivity
        )

    @property
    def mechanics(self) -> BondedLayer:
        """The layer's mechanics, with the cover or without."""
        return BondedLayer(self.covered)

    def readings(self, counts: Floats) -> Floats:
        """Readings (..., L) as a skin of even gains has them."""
        return np.asarray(counts / self.gain)

    @property
    def verdict(self) -> str:
        """What was found, in a sentence."""
        scale = (
            "forces are relative: press once with a known force"
            if self.relative
            else f"modulus {self.young_modulus / 1e3:.3g} ± {self.young_modulus_std / 1e3:.2g} kPa"
        )
        return (
            f"layer {self.thickness * 1e3:.3f} ± {self.thickness_std * 1e3:.3f} mm, Poisson's "
            f"ratio {self.poisson_ratio:.4f} ± {self.poisson_ratio_std:.4f}, "
            f"{'covered' if self.covered else 'no cover'}, gains ± "
            f"{100 * float(np.median(self.gain_std)):.1f} %, by {self.presses} presses "
            f"({self.left_out} left out), model {100 * self.model_error:.1f} % off; {scale}"
        )

    def __repr__(self) -> str:
        return f"TouchCalibration({self.verdict})"


def touch(
    patch: Patch,
    readings: ArrayLike,
    *,
    quantity: Quantity | None = None,
    noise_std: ArrayLike | None = None,
    layer: Layer | None = None,
    known: ArrayLike | None = None,
) -> TouchCalibration:
    """Calibrate a skin by presses or strokes of anything, some hundred of them.

    Parameters
    ----------
    patch : Patch
        Of L taxels.
    readings : (T, L) array, in the quantity's unit
        In any order, from rest; those without a press are passed over. NaN where a taxel did not
        answer.
    quantity : Quantity, optional
        Default `Capacitance()`.
    noise_std : float or (L,) array, in the quantity's unit, optional
        Of one reading. Default as taxels show it that are not pressed.
    layer : Layer, optional
        Nominal: the thickness within a third, the modulus stays. Default `Layer()`.
    known : (T,) array, N, optional
        Force of the readings that it is known of, NaN of others. Default none, and the answer is
        relative.

    Returns
    -------
    TouchCalibration

    Raises
    ------
    InputError
        If the arrays do not go together, or too few readings are presses.
    """
    quantity, layer = quantity or Capacitance(), layer or Layer()
    check_skin(patch, layer, BondedLayer(), quantity)
    table, heard = checked_readings(readings, None, patch, quantity)
    noise = _noise(patch, table, noise_std)
    forces = np.full(len(table), np.nan) if known is None else as_floats("known", known)
    check_shape("known", forces, (len(table),), "one per reading, NaN where it is not known")
    if (forces <= 0.0).any() or np.isinf(forces).any():
        raise InputError("known has a force of 0 or less, or infinity, expected N, or NaN")
    chosen = _presses(table, heard, noise, ~np.isnan(forces))
    data = Data(np.where(heard, table, 0.0)[chosen], heard[chosen], noise, patch.plane, quantity)
    nominal = np.array([np.log(layer.thickness), layer.poisson_ratio])
    fit = _fitted(patch, data, layer, nominal)
    state, kept, normal = fit.state, fit.fitted, fit.normal
    spread = np.asarray(np.linalg.inv(normal.schur), np.float64)
    std = np.sqrt(np.diag(spread))
    modulus, modulus_std = layer.young_modulus, np.nan
    force = forces[chosen][kept]
    if not np.isnan(force).all():
        ratio, part = _scale(force, state, normal, spread)
        modulus, modulus_std = modulus * ratio, modulus * ratio * part
    elif known is not None and not np.isnan(forces).all():
        raise InputError(
            "known has forces of readings that are none of one round press: expected one of a "
            "ball or fingertip amid the patch"
        )
    thickness, gain = float(np.exp(state.skin[0])), np.exp(state.log_gain)
    return TouchCalibration(
        thickness=thickness,
        thickness_std=thickness * float(std[0]),
        poisson_ratio=float(state.skin[1]),
        poisson_ratio_std=float(std[1]),
        young_modulus=float(modulus),
        young_modulus_std=float(modulus_std),
        relative_permittivity=layer.relative_permittivity,
        covered=fit.tables.cover,
        gain=gain,
        gain_std=gain * std[2:],
        noise_std=noise / gain,
        model_error=fit.error,
        presses=int(kept.sum()),
        left_out=int((~kept).sum()),
        relative=bool(np.isnan(modulus_std)),
    )


def _noise(patch: Patch, table: Floats, noise_std: ArrayLike | None) -> Floats:
    if noise_std is None:
        highest = np.nanmax(np.abs(table), axis=1, initial=0.0)
        idle = highest < TOUCHED * usual_deviation(table)
        quiet = table[idle] if idle.sum() >= IDLE else table
        noise = shared_noise(quiet, patch.neighbours)
        noise = np.where(np.isnan(noise), np.nanmedian(noise), noise)
    else:
        noise = as_floats("noise_std", noise_std)
        check_shape("noise_std", noise, (len(patch),) if noise.ndim else (), "one per taxel")
        noise = np.broadcast_to(noise, len(patch))
    if not (noise > 0.0).all():
        raise InputError(
            f"noise_std is {noise.min():g} of a taxel, expected more than 0, in the quantity's unit"
        )
    return noise


def _presses(
    table: Floats, heard: NDArray[np.bool_], noise: Floats, known: NDArray[np.bool_]
) -> NDArray[np.int64]:
    """Readings that are presses, `MOST` at most, evenly over the recording; all known ones."""
    loud = np.where(heard, table / noise, 0.0)
    found = np.flatnonzero((loud.max(axis=1) > LOUD) & (heard.sum(axis=1) > OWN))
    if len(found) < LEAST:
        raise InputError(
            f"readings has {len(found)} presses, expected {LEAST} or more, some hundred all over "
            f"the patch: readings that one taxel feels with {LOUD:g} times its noise"
        )
    even = found[np.unique(np.linspace(0, len(found) - 1, MOST).astype(np.int64))]
    return np.union1d(even, found[known[found]][:MOST])


@dataclass(frozen=True, eq=False)
class _Fit:
    """Of one skin, with a cover or without."""

    tables: PressTables
    state: State  # of the presses that are fitted
    fitted: NDArray[np.bool_]
    error: float
    priors: Priors
    normal: Normal
    likelihood: Floats  # logarithm, of each press


def _fitted(patch: Patch, data: Data, layer: Layer, nominal: Floats) -> _Fit:
    """Fit some presses with a cover and without, and all of them with what explains them better."""
    few = np.zeros(len(data.readings), np.bool_)
    few[np.unique(np.linspace(0, len(few) - 1, SOME).astype(np.int64))] = True
    some = data.only(few)
    skin = np.array([nominal[0], min(nominal[1], RATIO)])
    tries = []
    for cover in (False, True):
        tables = PressTables(layer, data.quantity, patch.pad_diameter, cover)
        tries.append(_stages(some, tables, nominal, skin, np.zeros(len(patch)), FIRST_ERROR))
    both = tries[0].fitted & tries[1].fitted
    best = max(tries, key=lambda each: float(each.likelihood[both].sum()))
    while True:
        skin, centre = best.state.skin, best.state.skin[0]
        near = replace(layer, thickness=float(np.exp(centre)))
        tables = PressTables(near, data.quantity, patch.pad_diameter, best.tables.cover, *NARROW)
        best = _stages(data, tables, nominal, skin, best.state.log_gain, NEXT_ERROR, best.priors)
        if abs(best.state.skin[0] - centre) < 0.9 * NARROW[0]:
            return best


def _stages(
    data: Data,
    tables: PressTables,
    nominal: Floats,
    skin: Floats,
    log_gain: Floats,
    error: float,
    before: Priors | None = None,
) -> _Fit:
    """Fit under a model error that falls to what is left, presses begun afresh each time."""
    state = State(np.empty((len(data.readings), OWN)), skin, log_gain)
    state = replace(state, touches=start(data, tables, state, error))
    priors = before or Priors.wide(nominal, np.median(state.touches[:, 2:], axis=0))
    for _ in range(STAGES):
        afresh = replace(state, touches=start(data, tables, state, error))
        state = refined(data, tables, [state, afresh], data.weight(error), priors)
        misfit = _squares(data, tables, state, error)
        kept = misfit < FAR * np.median(misfit)
        fit = JointFit(data.only(kept), tables, priors, error)
        part = fit.run(replace(state, touches=state.touches[kept]))
        priors = priors.updated(part, fit.normal(part))
        touches = state.touches.copy()
        touches[kept] = part.touches
        state = replace(part, touches=touches)
        error = max(_model_error(data.only(kept), tables, part), SLOWLY * error)
    squares = _squares(data, tables, state, error) * data.heard.sum(axis=1)
    spread = np.where(data.heard, np.log(data.variance(error)), 0.0)
    likelihood = -0.5 * (squares + spread.sum(axis=1))
    last = JointFit(data.only(kept), tables, priors, error)
    return _Fit(tables, part, kept, error, priors, last.normal(part), likelihood)


def _rest(data: Data, tables: PressTables, state: State) -> Floats:
    plain, _ = read(tables, state.touches, state.skin, data.taxels)
    return np.where(data.heard, data.readings - plain * np.exp(state.log_gain), 0.0)


def _squares(data: Data, tables: PressTables, state: State, error: float) -> Floats:
    """Mean (T,) of squared residuals over their variance."""
    squares = data.weight(error) * _rest(data, tables, state) ** 2
    return np.asarray(squares.sum(axis=1) / data.heard.sum(axis=1))


def _model_error(data: Data, tables: PressTables, state: State) -> float:
    """Most likely one, the parameters' share of the residuals given back."""
    count = float(data.heard.sum())
    lost = count / (count - state.touches.size - state.log_gain.size)
    square = lost * _rest(data, tables, state)[data.heard] ** 2
    costs = []
    for error in ERRORS:
        spread = data.variance(error)[data.heard]
        costs.append(float((square / spread + np.log(spread)).sum()))
    return float(ERRORS[int(np.argmin(costs))])


def _scale(force: Floats, state: State, normal: Normal, spread: Floats) -> tuple[float, float]:
    """By which forces are larger than those found, and its standard deviation as a part."""
    which = ~np.isnan(force)
    share = 1.0 / (normal.own[which, 2, 2] + FORCE_ERROR**2)
    off = np.log(force[which]) - state.touches[which, 2]
    common = share @ normal.coupling[which, :, 2] / share.sum()
    variance = 1.0 / share.sum() + float(common @ spread @ common)
    return float(np.exp(share @ off / share.sum())), float(np.sqrt(variance))
