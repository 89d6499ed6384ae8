r"""Images of contacts that sharpen as bodies move over the skin: super-resolution over time.

A reading knows little between taxels. But what moves is seen by other taxels: one field in the
body's own frame that is nowhere negative has to explain all readings of it,

.. math:: y_t = s_t\,A(x_t, y_t, \theta_t)\,p + \varepsilon_t, \qquad p \ge 0,

with the force's scale s of each reading, and its pose where nobody gives it, marginalised to first
order (variable projection; Golub and Pereyra, SIAM J. Numer. Anal. 10, 1973). The prior wants few
cells (a concave penalty on the pressure, which holds the force, too) with short edges (total
variation; Rudin, Osher and Fatemi, Physica D 60, 1992).
"""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from skinfield.errors import (
    Floats,
    InputError,
    as_floats,
    as_stamps,
    check_count,
    check_finite,
    check_positive,
    check_range,
    check_shape,
    check_type,
)
from skinfield.estimate import Estimate
from skinfield.estimate.contact_image import ContactImage
from skinfield.reconstruct.contact_image_fit import ImageFit, Response
from skinfield.reconstruct.reconstructor import Reconstructor, checked_readings

MARGIN = 0.4  # pitches around the taxels that feel a body first, in its image
SMALLEST = 2.2  # pitches from the middle of an image to its border, at least
SIDES = 8, 64  # cells along the side of an image
LOST, AGAIN = 2.0, 3  # misfit, over what it usually is, of a body that is another one; in a row
USUAL = 30  # readings over which a misfit is the usual one
UNEXPLAINED = 0.15  # of the highest reading: what bodies leave more of is a further one
FELT = 5.0  # times its noise: a reading of a body
BENDS = 0.5  # times its step, that a motion's steps differ from one another


class Touch(NamedTuple):
    """Taxels (N, 2) m that feel one body, and the centre (2,) m of what they read."""

    centre: Floats
    taxels: Floats


class _Body:
    """A body that touches: its fit, and when it was felt last."""

    def __init__(self, fit: ImageFit, number: int, centre: Floats) -> None:
        self.fit, self.number, self.centre = fit, number, centre
        self.unseen, self.lost, self.stamp, self.usual = 0, 0, 0, 1.0

    def judge(self) -> None:
        """Count for how many readings in a row it has not been what it was."""
        misfit = self.fit.misfit
        self.lost = self.lost + 1 if misfit > LOST * self.usual else 0
        self.usual += (min(misfit, LOST * self.usual) - self.usual) / USUAL
        self.usual = max(self.usual, 1.0)

    def image(self, rec: Reconstructor) -> ContactImage:
        fit = self.fit
        at, (x, y) = fit.snapshot(), fit.cells
        return ContactImage(
            pressure=fit.pressure,
            body_positions=np.stack(np.meshgrid(x, y), axis=-1),
            pose=fit.pose,
            patch=rec.patch,
            readings=fit.in_use,
            misfit=fit.misfit,
            track_id=self.number,
            stamp_ns=self.stamp,
            deviation=lambda: fit.deviation(at),
        )

    @property
    def reach(self) -> float:
        """From its centre to where it may be, m."""
        return 0.5 * self.fit.side * self.fit.cell

    def place(self) -> Floats:
        """Centre of its pressure in the plane, (2,) m."""
        weight = self.fit.pressure
        if not weight.any():
            return self.centre
        x, y = self.fit.cells
        mean = np.array([weight.sum(axis=0) @ x, weight.sum(axis=1) @ y]) / weight.sum()
        return _turned(mean, self.fit.pose[2]) + self.fit.pose[:2]


class ContactImages:
    """Pressure and outline of each body that touches, on a fine grid that moves along with it.

    Call `update` with each reading, or estimate, in turn. Images sharpen as bodies move by parts of
    the taxels' pitch, and turn; bodies that stay where they are gain from the mean alone.

    Parameters
    ----------
    rec : Reconstructor
        Of the patch: its model, and where contacts are first seen.
    cell : float, m
        Side of a cell of the images.
    readings : int
        That an image is made of, at most: of more, the last ones, so that what rolls is forgotten.
    step : float, m
    turn : float, rad
        How far a body moves, and turns, from one reading to the next (one standard deviation),
        where its poses are not given.
    near : float, m
        Taxels that are nearer to each other and feel something feel the same body.
    coast : int
        Readings for which a body may be unseen before it is forgotten.

    Attributes
    ----------
    images : tuple of ContactImage
        Of the bodies that touched in the last reading, by falling force.

    Examples
    --------
    >>> images = skinfield.ContactImages(rec)
    >>> for stamp_ns, readings in recording:
    ...     images.update(readings, stamp_ns=stamp_ns)
    >>> images.images[0].outline

    Notes
    -----
    A contact's force is known as one number per reading; a body that changes as it is pressed
    harder, as a ball does, is shown as it was in the last `readings` on the whole. Of an unknown
    motion, frames are known up to a small turn and shift that all readings share.
    """

    def __init__(
        self,
        rec: Reconstructor,
        *,
        cell: float = 0.8e-3,
        readings: int = 30,
        step: float = 0.7e-3,
        turn: float = 0.06,
        near: float = 16e-3,
        coast: int = 5,
    ) -> None:
        why = "of one patch: images of a whole skin are one ContactImages per patch"
        check_type("rec", rec, Reconstructor, why)
        check_range("cell", cell, 0.2e-3, 5e-3, "side of a cell in metres, some 0.4e-3 to 0.8e-3")
        check_count("readings", readings, 1, 1000, "that an image is made of")
        check_positive("step", step, "of a body from one reading to the next, in metres")
        check_positive("turn", turn, "of a body from one reading to the next, in radians")
        check_positive("near", near, "distance of taxels that feel one body, in metres")
        check_count("coast", coast, 0, 1_000_000, "readings for which a body may be unseen")
        self.rec, self.cell, self.near, self.coast = rec, cell, near, coast
        self._most, self._motion = readings, (step, turn)
        self._response = Response(rec.model, cell)
        self._next = 1
        self.reset()

    def reset(self) -> None:
        """Forget all bodies; numbers go on, so that none is given twice."""
        self._bodies: list[_Body] = []
        self.images: tuple[ContactImage, ...] = ()

    def update(
        self,
        readings: ArrayLike | Estimate,
        *,
        valid: ArrayLike | None = None,
        stamp_ns: ArrayLike = 0,
        poses: ArrayLike | None = None,
    ) -> tuple[ContactImage, ...]:
        """Take in one reading, or a run of them.

        Parameters
        ----------
        readings : (L,) or (T, L) array, in the quantity's unit; or Estimate
            As a `Reconstructor` takes them, or what it made of them.
        valid : (L,) or (T, L) bool array, optional
            False for taxels to leave out; those of an estimate are its own.
        stamp_ns : int or (T,) array, ns
        poses : (3,) or (T, 3) array, optional
            (x, y, turn) m, m, rad of the body that touches, in the patch's plane, as the robot
            knows them: of any frame of the body's, from the first reading of it on. All that
            touches is taken for one body then. Without poses motions are estimated along with the
            images, of each body by itself.

        Returns
        -------
        tuple of ContactImage
            `images` after the last reading.

        Raises
        ------
        InputError
            For readings, stamps or poses that do not fit each other or the patch; for poses of a
            body whose motion was estimated before, or none where they were given before.
        """
        if isinstance(readings, Estimate):
            table, mask = np.atleast_2d(readings.readings), np.atleast_2d(readings.valid)
            check_shape("readings", table, (None, len(self.rec.patch)), "an estimate of this patch")
            stamp_ns = readings.stamp_ns
        else:
            if self.rec._readings_from is not None:
                readings = self.rec._readings_from(as_floats("readings", readings))
            table, mask = checked_readings(readings, valid, self.rec.patch, self.rec.quantity)
        stamps = as_stamps("stamp_ns", stamp_ns)
        if stamps.shape not in ((), (len(table),)):
            raise InputError(f"stamp_ns has shape {stamps.shape}, expected one, or ({len(table)},)")
        stamps = np.broadcast_to(stamps, len(table))
        given = _checked_poses(poses, len(table))
        for t in range(len(table)):
            self._take(table[t], mask[t], int(stamps[t]), None if given is None else given[t])
        return self.images

    def _take(self, readings: Floats, valid: Any, stamp: int, pose: Floats | None) -> None:
        seen: list[_Body] = []
        if pose is not None:
            seen = self._at_pose(readings, valid, pose)
        elif any(body.fit.known for body in self._bodies):
            raise InputError(
                "poses is None, expected those of the body whose poses were given before: go on "
                "giving them, or call reset()"
            )
        elif self._is_felt(readings, valid):
            seen = self._followed(readings, valid)
        for body in self._bodies:
            body.unseen = 0 if body in seen else body.unseen + 1
            body.stamp = stamp if body in seen else body.stamp
        self._bodies = [body for body in self._bodies if body.unseen <= self.coast]
        images = [body.image(self.rec) for body in seen]
        self.images = tuple(sorted(images, key=lambda image: -image.force))

    def _is_felt(self, readings: Floats, valid: Any) -> bool:
        """Whether the readings are more than their noise, by the sum of their squares."""
        squares = np.square(readings[valid] / self.rec.model.noise_std[valid])
        count = len(squares)
        return bool(squares.sum() > count + FELT * np.sqrt(2.0 * count))

    def _touches(self, readings: Floats, valid: Any, beside: float = 0.0) -> list[Touch]:
        """Groups of taxels that feel something beyond noise, and beyond an error `beside`."""
        noise, taxels = np.hypot(self.rec.model.noise_std, beside), self.rec.model.taxels
        gap = max(self.near, 1.1 * self.rec.patch.pitch)
        return touches_of(np.where(valid, readings, np.nan), noise, taxels, gap)

    def _at_pose(self, readings: Floats, valid: Any, pose: Floats) -> list[_Body]:
        """The one body, at the pose that is given."""
        if not self._is_felt(readings, valid):
            return []
        if not self._bodies:
            touches = self._touches(readings, valid)
            if not touches:
                return []
            self._begin(_joined(touches), pose)
        body = self._bodies[0]
        if not body.fit.known:
            raise InputError(
                "poses are given of a body whose motion was estimated so far, in another frame: "
                "give them from its first reading on, or call reset()"
            )
        body.fit.update(readings, valid, pose)
        return [body]

    def _begin(self, touch: Touch, pose: Floats | None) -> _Body:
        """A body in a frame of its own, or in that of its pose."""
        pitch = self.rec.patch.pitch
        low, high = touch.taxels.min(axis=0), touch.taxels.max(axis=0)
        reach = max(float((high - low).max()) / 2 + MARGIN * pitch, SMALLEST * pitch)
        side = int(np.clip(np.ceil(2.0 * reach / self.cell), *SIDES))
        middle = (low + high) / 2 - touch.centre
        if pose is not None:
            middle = _turned((low + high) / 2 - pose[:2], -pose[2])
        bends = BENDS * self._motion[0], BENDS * self._motion[1]
        fit = ImageFit(
            self._response, middle, side, self._most, self._motion, bends,
            known=pose is not None,
        )  # fmt: skip
        body = _Body(fit, self._next, touch.centre)
        self._next += 1
        self._bodies.append(body)
        return body

    def _followed(self, readings: Floats, valid: Any) -> list[_Body]:
        """All bodies that touch, with the poses that explain the reading best."""
        seen, rest = [], np.array(readings)
        several = len(self._bodies) > 1
        expected = [
            body.fit.predicted() if several else np.zeros(len(rest)) for body in self._bodies
        ]
        for index, body in enumerate(self._bodies):
            others = sum(
                (part for k, part in enumerate(expected) if k != index), np.zeros(len(rest))
            )
            own = readings - others
            if not self._is_felt(own, valid):
                expected[index] = np.zeros(len(rest))
                continue
            centre = self._centre(own, valid, body)
            body.fit.update(own, valid, None, centre - body.centre)
            body.centre = centre
            body.judge()
            expected[index] = body.fit.predicted()
            seen.append(body)
        gone = [body for body in seen if body.lost >= AGAIN]
        for body in gone:  # what touches is no longer what it was: begin anew
            expected[self._bodies.index(body)][:] = 0.0
        self._bodies = [body for body in self._bodies if body not in gone]
        seen = [body for body in seen if body not in gone]
        rest = readings - sum(expected, np.zeros(len(rest)))
        beside = UNEXPLAINED * float(np.abs(readings[valid]).max()) if seen else 0.0
        touches = self._touches(rest, valid, beside / FELT)
        nearest = _nearest(touches, self.rec.patch.plane) if len(touches) else None
        for index, touch in enumerate(touches):
            if any(np.hypot(*(touch.centre - body.place())) < body.reach for body in seen):
                continue
            body = self._begin(touch, None)
            for old in gone:
                if np.hypot(*(touch.centre - old.centre)) < old.reach:
                    body.number = old.number
            body.fit.update(rest, valid & (nearest == index), np.array([*touch.centre, 0.0]))
            seen.append(body)
        return seen

    def _centre(self, readings: Floats, valid: Any, body: _Body) -> Floats:
        """Of what the taxels around a body read."""
        taxels = self.rec.model.taxels
        near = valid & (np.hypot(*(taxels - body.place()).T) < body.reach)
        weight = np.where(near, np.maximum(readings, 0.0), 0.0)
        return np.asarray(weight @ taxels / weight.sum()) if weight.sum() > 0.0 else body.centre


def touches_of(readings: Floats, noise: Floats, taxels: Floats, gap: float) -> list[Touch]:
    """Groups of taxels that feel a body, or how the skin bulges beside it, by falling reading.

    Parameters
    ----------
    readings, noise : (L,) arrays
        NaN where a taxel did not answer.
    taxels : (L, 2) array, m
    gap : float, m
        Taxels that are nearer to each other are of one group if both feel something.
    """
    clear = np.nan_to_num(readings) / noise
    if clear.max() <= FELT:
        return []
    from scipy.sparse.csgraph import connected_components
    from scipy.spatial.distance import cdist

    felt = np.flatnonzero(np.abs(clear) > FELT)
    near = cdist(taxels[felt], taxels[felt]) < gap
    count, group = connected_components(near, directed=False)
    found = []
    for each in range(count):
        part = felt[group == each]
        weight = np.maximum(readings[part], 0.0)
        if clear[part].max() > FELT:  # else it is the bulge beside something
            centre = weight @ taxels[part] / weight.sum()
            found.append((float(weight.max()), Touch(centre, taxels[part])))
    return [touch for _, touch in sorted(found, key=lambda pair: -pair[0])]


def _joined(touches: list[Touch]) -> Touch:
    """All of them as one."""
    counts = np.array([len(touch.taxels) for touch in touches])
    centre = counts @ np.array([touch.centre for touch in touches]) / counts.sum()
    return Touch(centre, np.concatenate([touch.taxels for touch in touches]))


def _nearest(touches: list[Touch], taxels: Floats) -> Any:
    """Which touch each taxel is nearest to, (L,)."""
    away = [
        np.hypot(*np.moveaxis(taxels[:, None] - touch.taxels[None], -1, 0)).min(axis=1)
        for touch in touches
    ]
    return np.argmin(away, axis=0)


def _turned(place: Floats, angle: float) -> Floats:
    cos, sin = np.cos(angle), np.sin(angle)
    return np.array([cos * place[0] - sin * place[1], sin * place[0] + cos * place[1]])


def _checked_poses(poses: ArrayLike | None, count: int) -> Floats | None:
    if poses is None:
        return None
    why = "(x, y, turn) of the body in m, m and rad for each reading"
    table = np.atleast_2d(as_floats("poses", poses))
    check_shape("poses", table, (count, 3), why)
    check_finite("poses", table, why)
    return table
