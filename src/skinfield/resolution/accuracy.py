r"""How well place and force of a touch can be told: the Cramér-Rao bound, place by place.

With readings y(θ), noise σ and θ = (x, y, ln F, ln a), no unbiased estimate has a smaller
covariance than

.. math:: \Big(J^T \mathrm{diag}(\sigma^{-2}) J + P\Big)^{-1}, \quad J = \partial y/\partial\theta,

P the information on the radius a that there is before any reading (Van Trees, Detection,
Estimation and Modulation Theory I, section 2.4). Values far beyond the distance of two taxels mean
that the readings say next to nothing: any guess inside the patch is better.
"""

from dataclasses import dataclass

import numpy as np

from skinfield.errors import Floats, check_positive
from skinfield.resolution.design import Places, SkinDesign, Touch
from skinfield.resolution.response import respond

SIZE_PRIOR = 0.6  # standard deviation of ln radius of everyday contacts
SINGULAR = 1e-12  # smallest eigenvalue of a correlation matrix that can be told from 0


@dataclass(frozen=True, eq=False)
class PlaceAccuracy:
    """Smallest standard deviations of one reading's unbiased estimates, place by place.

    Attributes
    ----------
    places : Places
    touch : Touch
    place_std, place_std_known_size : (P,) arrays, m
        Root of the sum of the variances along the plane's axes, with the radius unknown and known.
        Infinite where the readings cannot tell.
    force_std, force_std_known_size : (P,) arrays, N
    size_prior : float
        Standard deviation of ln radius before any reading, where it is unknown.
    """

    places: Places
    touch: Touch
    place_std: Floats
    place_std_known_size: Floats
    force_std: Floats
    force_std_known_size: Floats
    size_prior: float


def place_accuracy(
    design: SkinDesign,
    touch: Touch,
    places: Places | None = None,
    *,
    size_prior: float = SIZE_PRIOR,
) -> PlaceAccuracy:
    """Bound of place and force of a touch everywhere on a layout.

    Parameters
    ----------
    design : SkinDesign
    touch : Touch
    places : Places, optional
        Default `Places.over` the patch.
    size_prior : float
        Standard deviation of ln radius before any reading.
    """
    check_positive("size_prior", size_prior, "standard deviation of ln radius")
    places = Places.over(design.patch) if places is None else places
    information = respond(design, touch, places.plane).gram[:, 1:, 1:].copy()
    place_known, force_known = bounds(information[:, :3, :3])
    information[:, 3, 3] += size_prior**-2
    place, force = bounds(information)
    touch_force = touch.force
    return PlaceAccuracy(
        places,
        touch,
        place,
        place_known,
        touch_force * force,
        touch_force * force_known,
        size_prior,
    )


def bounds(information: Floats) -> tuple[Floats, Floats]:
    """Deviations of the place m and of ln force from information matrices (P, 3 or 4, same)."""
    scale = np.sqrt(np.einsum("pii->pi", information))
    seen = (scale > 0.0).all(axis=1)
    place, force = np.full(len(scale), np.inf), np.full(len(scale), np.inf)
    scale, rows = scale[seen], np.flatnonzero(seen)
    correlation = information[seen] / (scale[:, :, None] * scale[:, None, :])
    told = np.linalg.eigvalsh(correlation)[:, 0] > SINGULAR
    variance = np.einsum("pii->pi", np.linalg.inv(correlation[told])) / scale[told] ** 2
    place[rows[told]] = np.sqrt(variance[:, 0] + variance[:, 1])
    force[rows[told]] = np.sqrt(variance[:, 2])
    return place, force
