"""One factor between two forces that were recorded side by side."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import Floats, InputError, check_finite, check_shape
from skinfield.skin.reading import Recording

AXES = {"x": 0, "y": 1, "z": 2}
FEWEST = 8  # readings within the reference's time
VARIES = 0.1  # of its mean: a force that varies less is a constant load, whose correlation is noise
RELATED = 0.1  # correlation from which on two forces that vary can be one load


def column_of(sensor: Recording, axis: str) -> Floats:
    """Force along an axis such as "z" or "-z" from a recording of fx fy fz (mx my mz), (T,) N."""
    name, sign = axis.lstrip("+-"), -1.0 if axis.startswith("-") else 1.0
    if name not in AXES:
        raise InputError(f"axis is {axis!r}, expected x, y, z, -x, -y or -z of the sensor")
    columns = sensor.counts.shape[1]
    if columns not in (3, 6):
        raise InputError(
            f"{sensor.source} has {columns} columns, expected 3 or 6 (fx fy fz mx my mz): "
            "give the recording of the force/torque sensor second, the skin's first"
        )
    return np.asarray(sign * sensor.counts[:, AXES[name]])


@dataclass(frozen=True, eq=False)
class ScaleFit:
    """Least-squares factor from a reconstructed force to a reference, and how well it does.

    Attributes
    ----------
    factor : float
        Over all readings.
    factor_std : float
        From the scatter of the factor over ten blocks of time: readings are not independent.
    first_half : float
        The factor that the first half alone gives.
    rms, held_out_rms : float, N
        Error over all readings with `factor`; over the second half with `first_half`.
    mean_reference, reference_std : float, N
        A constant would be off by `reference_std`: a skin that does worse has not been tried.
    correlation : float
        Of the two forces over time.
    reference : (T,) array, N
        At the skin's stamps; NaN outside the reference's time.
    """

    factor: float
    factor_std: float
    first_half: float
    rms: float
    held_out_rms: float
    mean_reference: float
    reference_std: float
    correlation: float
    reference: Floats

    def numbers(self) -> dict[str, Any]:
        """All but the series, by name and unit."""
        return {
            "factor": self.factor,
            "factor_std": self.factor_std,
            "factor_first_half": self.first_half,
            "rms_N": self.rms,
            "held_out_rms_N": self.held_out_rms,
            "mean_reference_N": self.mean_reference,
            "reference_std_N": self.reference_std,
            "correlation": self.correlation,
        }

    def sentences(self, modulus_kpa: float) -> str:
        """The result in words."""
        share = 100 * self.rms / abs(self.mean_reference)
        held = 100 * self.held_out_rms / abs(self.mean_reference)
        return (
            f"modulus {modulus_kpa:.4g} kPa: the reconstructed force times {self.factor:.4g} "
            f"± {self.factor_std:.2g}\n"
            f"error over all readings: {self.rms:.1f} N rms, {share:.0f} % of the mean "
            f"{self.mean_reference:.1f} N; correlation {self.correlation:.2f}\n"
            f"fitted on the first half, judged on the second: {self.held_out_rms:.1f} N rms, "
            f"{held:.0f} %\n"
            f"the reference itself varies by {self.reference_std:.1f} N: a constant would be that "
            "far off"
        )


def fit_scale(
    stamp_ns: NDArray[np.int64],
    force: Floats,
    reference_stamp_ns: NDArray[np.int64],
    reference: Floats,
) -> ScaleFit:
    """Fit factor * force = reference over the time that both cover.

    Parameters
    ----------
    stamp_ns, force : (T,) arrays, ns and N
        Of the skin.
    reference_stamp_ns, reference : (R,) arrays, ns and N
        Of the sensor, interpolated to the skin's stamps.

    Raises
    ------
    InputError
        If they hardly overlap in time, if the skin's force is zero throughout, if no positive
        factor fits, or if a load that varies is not seen by both.
    """
    check_shape("force", force, stamp_ns.shape, "one per stamp")
    check_shape("reference", reference, reference_stamp_ns.shape, "one per stamp")
    check_finite("force", force, "a reading without a force cannot be compared")
    origin = stamp_ns[0]
    time, other = (stamp_ns - origin) * 1e-9, (reference_stamp_ns - origin) * 1e-9
    aligned = np.interp(time, other, reference, left=np.nan, right=np.nan)
    both = np.isfinite(aligned)
    if both.sum() < FEWEST:
        raise InputError(
            f"{int(both.sum())} of {len(time)} readings lie within the force sensor's time "
            f"({other[0]:.2f} to {other[-1]:.2f} s after the first reading), expected {FEWEST} or "
            "more: are both of one experiment?"
        )
    skin, sensor = force[both], aligned[both]
    if not skin.any():
        raise InputError("the reconstructed force is 0 throughout, expected some load to fit")
    middle = len(skin) // 2
    factor, first = _factor(skin, sensor), _factor(skin[:middle], sensor[:middle])
    blocks = [
        _factor(a, b)
        for a, b in zip(np.array_split(skin, 10), np.array_split(sensor, 10), strict=True)
        if len(a) and a.any()
    ]
    spread = np.std(blocks, ddof=1) / np.sqrt(len(blocks)) if len(blocks) > 1 else np.nan
    varies = np.ptp(skin) > 0 and np.ptp(sensor) > 0
    correlation = float(np.corrcoef(skin, sensor)[0, 1]) if varies else float("nan")
    _check_one_load(skin, sensor, factor, correlation)
    return ScaleFit(
        factor=factor,
        factor_std=float(spread),
        first_half=first,
        rms=_rms(factor * skin - sensor),
        held_out_rms=_rms(first * skin[middle:] - sensor[middle:]),
        mean_reference=float(sensor.mean()),
        reference_std=float(sensor.std()),
        correlation=correlation,
        reference=aligned,
    )


def _check_one_load(skin: Floats, sensor: Floats, factor: float, correlation: float) -> None:
    """Refuse forces that cannot be one load on both, (T,) N each."""
    if not sensor.any():
        raise InputError(
            "the sensor's force is 0 throughout, expected some load to fit: is it dead, or another "
            "axis?"
        )
    turn = "the sensor's axis points the other way: turn its sign (axis z instead of -z)"
    if not factor > 0.0:
        raise InputError(
            f"the factor from the skin's force (mean {skin.mean():.4g} N) to the sensor's (mean "
            f"{sensor.mean():.4g} N) is {factor:.4g}, expected one above 0: {turn}, or choose the "
            "axis that points into the skin"
        )
    moves = {"skin": _varies(skin), "sensor": _varies(sensor)}
    if not any(moves.values()) or correlation >= RELATED:
        return
    if correlation <= -RELATED:
        cause = turn
    elif all(moves.values()):
        cause = "the recordings are not of one experiment or one clock, or the axis is another"
    else:
        still = "sensor" if moves["skin"] else "skin"
        cause = f"the {still} does not follow a load that varies: is it dead, or the axis another?"
    number = "not defined" if np.isnan(correlation) else f"{correlation:.2f}"
    raise InputError(
        f"the correlation of the skin's force with the sensor's is {number}, expected {RELATED:g} "
        f"or more where a load varies: {cause}"
    )


def _varies(force: Floats) -> bool:
    return bool(force.std() > VARIES * abs(force.mean()))


def _factor(force: Floats, reference: Floats) -> float:
    power = float(force @ force)
    return float(force @ reference) / power if power > 0 else float("nan")


def _rms(error: Floats) -> float:
    return float(np.sqrt(np.mean(error**2)))
