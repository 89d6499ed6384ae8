"""Patches and skins: the taxels under one sheet of elastomer, and all patches of one robot."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from skinfield.errors import Floats, InputError, Ints, as_floats, check_finite, check_shape
from skinfield.plot import Pictured, Place, drawing, number, plural
from skinfield.skin.flattening import Surface, surface_through
from skinfield.skin.geometry import spans_plane

LISTED = 12  # names of patches in a table of facts
PER_TAXEL = ("positions", "normals", "module", "uid", "channel")
COARSEST = 0.1  # m between taxels under one sheet: no skin has that, so these are millimetres
WIDEST = 10.0  # m from end to end of one sheet
MOST_APART = 30_000  # taxels: no more fit flat into that with half of them COARSEST from all others
LARGEST_PAD = 0.1  # m


@dataclass(frozen=True, eq=False, repr=False)
class Patch(Pictured):
    """The taxels under one elastomer sheet, reconstructed independently. A taxel is a row.

    Parameters
    ----------
    positions : (L, 3) or (L, 2) array, m
        Centres of the pads, in the patch's own frame; a third column of zeros is added to (L, 2).
    pad_diameter : float, m
        Of the round electrode of one taxel.
    normals : (L, 3) array, optional
        Outward, from the robot to whatever touches it; made unit length. Default the side of +z
        where the taxels lie in a plane; else estimated from the positions, to the convex side.
    module : (L,) int array, optional
        Index of the board that carries the taxel. Default 0.
    uid : (L,) uint64 array, optional
        Identity of the taxel in its maker's numbering. Default the row.
    channel : (L,) int array, optional
        Column of the taxel in the readings of its port. Default the row.
    n_channels : int, optional
        Columns of the port, thermal and absent ones included. Default the largest channel + 1.
    name, link : str
        Of the patch, and of the robot's link that carries it.
    link_from_patch : (4, 4) array, optional
        Homogeneous pose of the patch in its link, m. Default the identity.

    Notes
    -----
    All arrays are copies, and read-only.

    Raises
    ------
    InputError
        If lengths are those of no skin: millimetres that were given as metres, most likely.
    """

    positions: Floats
    pad_diameter: float = 4e-3
    normals: Floats = field(default=None, kw_only=True)  # type: ignore[arg-type]
    module: Ints = field(default=None, kw_only=True)  # type: ignore[arg-type]
    uid: NDArray[np.uint64] = field(default=None, kw_only=True)  # type: ignore[arg-type]
    channel: Ints = field(default=None, kw_only=True)  # type: ignore[arg-type]
    n_channels: int = field(default=0, kw_only=True)
    name: str = field(default="patch", kw_only=True)
    link: str = field(default="", kw_only=True)
    link_from_patch: Floats = field(default=None, kw_only=True)  # type: ignore[arg-type]

    def __post_init__(self) -> None:
        positions = _positions(self.positions)
        _check_lengths(self.name, positions, self.pad_diameter)
        rows = np.arange(len(positions))
        given = self.normals is not None
        columns = {
            "positions": positions,
            "normals": _unit(self.normals, rows) if given else _default_normals(positions),
            "module": _whole("module", self.module, np.zeros(len(rows), np.int64)),
            "uid": _whole("uid", self.uid, rows.view(np.uint64)),
            "channel": _whole("channel", self.channel, rows),
            "link_from_patch": _pose(self.link_from_patch),
        }
        highest = int(columns["channel"].max()) + 1
        if self.n_channels and self.n_channels < highest:
            raise InputError(
                f"n_channels is {self.n_channels}, expected at least {highest}: "
                "every channel must be a column of the port"
            )
        for name, value in columns.items():
            value.setflags(write=False)
            object.__setattr__(self, name, value)
        object.__setattr__(self, "n_channels", int(self.n_channels) or highest)

    def __len__(self) -> int:
        return len(self.positions)

    def __repr__(self) -> str:
        size = " x ".join(f"{side * 1e3:.1f}" for side in np.ptp(self.positions, axis=0))
        modules = len(np.unique(self.module))
        return f"Patch({self.name!r}, {len(self)} taxels, {modules} modules, {size} mm)"

    def __getstate__(self) -> dict[str, Any]:
        """Fields, for copies and pickles: what is worked out from them stays behind."""
        return {name: vars(self)[name] for name in self.__dataclass_fields__}

    def __setstate__(self, state: dict[str, Any]) -> None:
        for value in state.values():
            if isinstance(value, np.ndarray):
                value.setflags(write=False)
        vars(self).update(state)

    def plot(self, ax: Place = None) -> Any:
        """Draw the pads to scale, in the colours of their modules; lengths in mm.

        Parameters
        ----------
        ax : matplotlib Axes, optional
            To draw in. Default those of a new figure. A curved patch is drawn in space where they
            are 3D, as new ones are for it; else it is flattened.

        Returns
        -------
        matplotlib Axes

        Raises
        ------
        InputError
            If `ax` is something else, or Matplotlib is not installed.

        Examples
        --------
        >>> import skinfield as sf
        >>> sf.layouts.hexagon72().plot().get_xlabel()
        'x (mm)'
        """
        return drawing("skinfield.skin.plot:plot_patch")(self, ax)

    def _facts(self) -> Mapping[str, str]:
        sides = " × ".join(number(side * 1e3) for side in np.ptp(self.positions, axis=0))
        return {
            "Patch": self.name,
            "taxels": str(len(self)),
            "modules": str(len(np.unique(self.module))),
            "size": f"{sides} mm",
            "pitch": f"{number(self.pitch * 1e3)} mm",
            "pad diameter": f"{number(self.pad_diameter * 1e3)} mm",
            **({"link": self.link} if self.link else {}),
        }

    @cached_property
    def surface(self) -> Surface:
        """The developed surface through the taxels: a plane of metres and the way back to 3D."""
        return surface_through(self.positions, self.normals)

    @property
    def plane(self) -> Floats:
        """Taxel centres in the patch's own plane, (L, 2) m."""
        return self.surface.plane

    @cached_property
    def pitch(self) -> float:
        """Median distance from a taxel to its nearest neighbour, m; the pad's diameter if alone."""
        from skinfield.skin.geometry import nearest_distance

        pitch = float(np.median(nearest_distance(self._distinct[0])))
        return pitch if np.isfinite(pitch) else self.pad_diameter

    @cached_property
    def triangles(self) -> Ints:
        """Delaunay triangulation of the taxels in the patch's plane, (T, 3) rows of taxels.

        Of taxels at one place, the first takes part. Empty where all lie on one line.
        """
        from scipy.spatial import Delaunay

        distinct, row = self._distinct
        if not spans_plane(distinct):
            return np.empty((0, 3), np.int64)
        corners = Delaunay(distinct - distinct.mean(axis=0)).simplices
        return np.asarray(row[corners], dtype=np.int64)

    @cached_property
    def neighbours(self) -> Ints:
        """Pairs (P, 2), rows of taxels joined by an edge of `triangles` of at most 2 pitches.

        The lower row first. Where all taxels lie on one line, those next to each other.
        """
        if len(self.triangles):
            sides = self.triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2)
        else:
            distinct, row = self._distinct
            centred = distinct - distinct.mean(axis=0)
            order = row[np.argsort(centred @ np.linalg.svd(centred)[2][0], kind="stable")]
            sides = np.column_stack([order[:-1], order[1:]])
        sides = np.unique(np.sort(sides, axis=1), axis=0)
        length = np.linalg.norm(np.diff(self.plane[sides], axis=1)[:, 0], axis=1)
        return np.asarray(sides[length <= 2.0 * self.pitch], dtype=np.int64)

    def subset(self, rows: ArrayLike) -> "Patch":
        """Patch of the chosen taxels; channels, uids and the port's width stay theirs.

        Parameters
        ----------
        rows : (L,) bool array, or int array
            Mask over the taxels, or their rows in the order wanted.
        """
        rows = np.asarray(rows) if np.size(rows) else np.zeros(0, np.int64)
        try:
            check_shape("rows", self.channel[rows], (None,), "a mask, or one row per taxel")
        except IndexError as error:
            raise InputError(
                f"rows has shape {rows.shape} and type {rows.dtype}, expected a mask of "
                f"{len(self)} taxels or whole numbers below {len(self)}: {error}"
            ) from error
        return replace(self, **{name: getattr(self, name)[rows] for name in PER_TAXEL})

    @cached_property
    def _distinct(self) -> tuple[Floats, Ints]:
        """Places of the plane (D, 2) that hold a taxel, and the first row at each (D,)."""
        _, row = np.unique(self.plane.round(7), axis=0, return_index=True)
        row = np.sort(row).astype(np.int64)
        return self.plane[row], row


def millimetres_in(positions: Floats) -> str:
    """Why positions (L, 3) can only be millimetres given as metres, in words; "" if they need not.

    Taxels at one place count once.
    """
    from skinfield.skin.geometry import nearest_distance

    extent = float(np.ptp(positions, axis=0).max())
    if extent <= WIDEST and len(positions) > MOST_APART:
        return ""
    distance = nearest_distance(positions)
    pitch = float(np.median(distance)) if np.isfinite(distance).all() else 0.0
    if pitch <= COARSEST and extent <= WIDEST:
        return ""
    return (
        f"taxels are {pitch:.3g} m apart over {extent:.3g} m, which no skin is: "
        "these are millimetres given as metres"
    )


def _check_lengths(name: str, positions: Floats, pad_diameter: float) -> None:
    if why := millimetres_in(positions):
        raise InputError(
            f"{name}: {why}; expected metres, at most {COARSEST:g} m apart and {WIDEST:g} m from "
            "end to end: divide positions by 1000"
        )
    if not 0.0 < pad_diameter < LARGEST_PAD:
        raise InputError(
            f"pad_diameter is {pad_diameter!r} m, expected a length above 0 and below "
            f"{LARGEST_PAD:g}: give it in metres, 4 mm is 4e-3"
        )


def _positions(values: ArrayLike) -> Floats:
    positions = as_floats("positions", values)
    if positions.ndim != 2 or positions.shape[1] not in (2, 3) or len(positions) == 0:
        raise InputError(
            f"positions has shape {positions.shape}, expected (taxels, 2) or (taxels, 3) "
            "with at least one taxel: one row of metres per taxel"
        )
    check_finite("positions", positions, "an absent taxel is left out, not marked by NaN")
    if positions.shape[1] == 2:
        return np.column_stack([positions, np.zeros(len(positions))])
    return np.array(positions, order="C")


def _default_normals(positions: Floats) -> Floats:
    """Outward normals where none are known, (L, 3)."""
    from skinfield.skin.geometry import facing_from_positions

    up = np.broadcast_to([0.0, 0.0, 1.0], positions.shape)
    if np.ptp(positions[:, 2]) < 1e-9:
        return up
    facing = facing_from_positions(positions)
    if not facing.is_flat:
        return facing.normals
    leading = next(c for c in facing.normals[0, ::-1] if abs(c) > 1e-9)
    return np.asarray(facing.normals * np.sign(leading))


def _unit(values: ArrayLike, rows: Ints) -> Floats:
    normals = as_floats("normals", values)
    check_shape("normals", normals, (len(rows), 3), "one per row of positions")
    length = np.linalg.norm(normals, axis=1, keepdims=True)
    good = np.isfinite(length) & (length > 1e-9)
    if not good.all():
        row = int(np.argmin(good))
        raise InputError(
            f"normals[{row}] is {normals[row]}, expected a vector that points out of the skin: "
            "leave normals out to have them estimated from the positions"
        )
    return np.ascontiguousarray(normals / length)


def _whole(name: str, values: ArrayLike | None, default: Ints) -> Ints:
    """Whole numbers from 0, one per taxel, a copy in the type of the default."""
    if values is None:
        return default
    column = np.asarray(values)
    check_shape(name, column, (len(default),), "one per row of positions")
    whole = column.dtype.kind in "iu" or (column.dtype.kind == "f" and (column % 1 == 0).all())
    if not whole or (column < 0).any():
        raise InputError(f"{name} is {column}, expected whole numbers from 0, one per taxel")
    return column.astype(default.dtype)


def _pose(values: ArrayLike | None) -> Floats:
    pose = np.eye(4) if values is None else np.array(as_floats("link_from_patch", values))
    check_shape("link_from_patch", pose, (4, 4), "a homogeneous pose")
    turn = pose[:3, :3]
    rigid = np.abs(turn @ turn.T - np.eye(3)).max() < 0.01 and np.linalg.det(turn) > 0
    if not (np.isfinite(pose).all() and rigid and np.abs(pose[3] - [0, 0, 0, 1]).max() < 1e-9):
        raise InputError(
            f"link_from_patch is {pose.tolist()}, expected a rotation, a shift in metres and "
            "a last row of 0 0 0 1"
        )
    return pose


@dataclass(frozen=True, eq=False, repr=False)
class Skin(Pictured):
    """All patches of one robot; each patch knows its link and its pose there.

    Parameters
    ----------
    patches : sequence of Patch, or one Patch
        At least one, of distinct names.
    name : str
        Of the robot or of the file it came from.
    notes : sequence of str
        What the importer repaired or left out, in sentences.
    """

    patches: tuple[Patch, ...]
    name: str = "skin"
    notes: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        patches = (self.patches,) if isinstance(self.patches, Patch) else tuple(self.patches)
        object.__setattr__(self, "patches", patches)
        object.__setattr__(self, "notes", tuple(self.notes))
        names = [patch.name for patch in self.patches]
        if not names or len(set(names)) < len(names):
            raise InputError(f"patches are named {names}, expected one or more, each name once")

    def __iter__(self) -> Iterator[Patch]:
        return iter(self.patches)

    def __repr__(self) -> str:
        taxels, patches = self._size()
        return f"Skin({self.name!r}, {taxels} on {patches})"

    def _size(self) -> tuple[str, str]:
        return plural(sum(map(len, self)), "taxel"), plural(len(self), "patch", "patches")

    def plot(self, ax: Place = None) -> Any:
        """Draw all patches to one scale, each in its own plane, side by side; lengths in mm.

        Of a skin of one patch it is `Patch.plot`.

        Parameters
        ----------
        ax : matplotlib Axes, optional
            To draw in. Default those of a new figure.

        Returns
        -------
        matplotlib Axes

        Raises
        ------
        InputError
            If `ax` is something else, or Matplotlib is not installed.
        """
        return drawing("skinfield.skin.plot:plot_skin")(self, ax)

    def _facts(self) -> Mapping[str, str]:
        listed = ", ".join(patch.name for patch in self.patches[:LISTED])
        taxels, patches = self._size()
        links = sorted({patch.link for patch in self} - {""})
        return {
            "Skin": self.name,
            "patches": f"{patches}: {listed}{', …' if len(self) > LISTED else ''}",
            "taxels": taxels,
            **({"links": ", ".join(links[:LISTED])} if links else {}),
            **({"notes": "; ".join(self.notes)} if self.notes else {}),
        }

    def __len__(self) -> int:
        return len(self.patches)

    def __getitem__(self, key: int | str) -> Patch:
        names = [patch.name for patch in self.patches]
        if isinstance(key, str):
            if key in names:
                return self.patches[names.index(key)]
        elif -len(self) <= key < len(self):
            return self.patches[key]
        raise InputError(
            f"patch {key!r} is not in {self.name!r}, expected one of {', '.join(names)} "
            f"or a number below {len(self)}"
        )
