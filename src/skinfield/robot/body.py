"""Body of a robot: links and joints, their poses at joint positions, and the skin on the links."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike

from skinfield.errors import Floats, InputError, as_floats, check_finite, check_shape, needs
from skinfield.estimate import Contact
from skinfield.plot import plural
from skinfield.settings import nearest
from skinfield.skin import Patch, Skin

Kind = Literal["revolute", "continuous", "prismatic", "fixed"]
TOGETHER = 32  # points whose distances from all triangles are there at once
JointPositions = Mapping[str, float] | ArrayLike | None


@dataclass(frozen=True, eq=False, kw_only=True)
class Mesh:
    """Triangle mesh by which a link is drawn.

    Attributes
    ----------
    path : Path
        As the description names it, which may not be there.
    link_from_mesh : (4, 4) array
        Pose in the link, m, of the scaled mesh.
    scale : (3,) array
        Metres of one unit of the file along its axes.
    """

    path: Path
    link_from_mesh: Floats
    scale: Floats


@dataclass(frozen=True, eq=False, kw_only=True)
class Link:
    """Rigid part of a robot.

    Attributes
    ----------
    name : str
    meshes : tuple of Mesh
        Of its visuals; those that are boxes, cylinders or spheres are left out.
    """

    name: str
    meshes: tuple[Mesh, ...] = ()

    def distance(self, points: Floats) -> Floats:
        """Distance of points (N, 3), m in the link's frame, from its meshes, (N,) m.

        Raises
        ------
        InputError
            If no mesh of it is there, one cannot be read, or trimesh is missing.
        """
        from skinfield.simulate.indenters.shape_files import read_triangles

        meshes = [mesh for mesh in self.meshes if mesh.path.is_file()]
        if not meshes:
            tried = ", ".join(str(mesh.path) for mesh in self.meshes) or "the URDF names none"
            raise InputError(
                f"link {self.name!r} has no mesh ({tried}), expected one that is there: put the "
                "meshes where the URDF says"
            )
        corners = []
        for mesh in meshes:
            vertices, faces = read_triangles(mesh.path)
            turn, shift = mesh.link_from_mesh[:3, :3], mesh.link_from_mesh[:3, 3]
            corners.append(((vertices * mesh.scale) @ turn.T + shift)[faces])
        triangles = np.concatenate(corners)
        whole = np.isfinite(triangles).all(axis=(1, 2))
        return distance_from_triangles(triangles[whole], points)


@dataclass(frozen=True, kw_only=True)
class Mimic:
    """Joint that moves with another: its position is `multiplier` times the other's + `offset`."""

    joint: str
    multiplier: float = 1.0
    offset: float = 0.0


@dataclass(frozen=True, eq=False, kw_only=True)
class Joint:
    """Joint between two links.

    Attributes
    ----------
    name : str
    kind : "revolute", "continuous", "prismatic" or "fixed"
    parent, child : str
        Names of the links.
    parent_from_joint : (4, 4) array
        Pose of the child in the parent at position 0, m.
    axis : (3,) array
        Unit vector in the joint's frame.
    limits : (float, float) or None, rad or m
        Lowest and highest position; None of a continuous or fixed joint.
    mimic : Mimic or None
    """

    name: str
    kind: Kind
    parent: str
    child: str
    parent_from_joint: Floats
    axis: Floats
    limits: tuple[float, float] | None = None
    mimic: Mimic | None = None

    def parent_from_child(self, position: float) -> Floats:
        """Pose (4, 4) of the child in the parent at a position, rad or m."""
        motion = np.eye(4)
        if self.kind == "prismatic":
            motion[:3, 3] = position * self.axis
        elif self.kind != "fixed":
            motion[:3, :3] = rotation(position, self.axis)
        return np.asarray(self.parent_from_joint @ motion)


def rotation(angle: float, axis: Floats) -> Floats:
    """Rotation matrix (3, 3) by an angle, rad, about a unit axis: Rodrigues' formula."""
    x, y, z = axis
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.asarray(np.eye(3) + np.sin(angle) * cross + (1.0 - np.cos(angle)) * cross @ cross)


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class Robot:
    """A tree of links and joints, with patches of skin on some of the links; see `load_robot`.

    The base is the link that is no joint's child. Joint positions, rad or m, are a mapping from
    names of joints, in which those left out are at 0, or an array in the order of `joint_names`.

    Attributes
    ----------
    name : str
    links : tuple of Link
        In the description's order.
    joints : tuple of Joint
        From the base outwards.
    patches : tuple of Patch
        Each knows its link, and is in the link's frame.
    notes : tuple of str
        How the skin came onto the links, in sentences.
    """

    name: str
    links: tuple[Link, ...]
    joints: tuple[Joint, ...]
    patches: tuple[Patch, ...] = ()
    notes: tuple[str, ...] = field(default=())

    def __repr__(self) -> str:
        taxels = sum(map(len, self.patches))
        parts = plural(len(self.links), "link"), plural(len(self.joint_names), "joint")
        return f"Robot({self.name!r}, {', '.join(parts)}, {plural(taxels, 'taxel')})"

    @cached_property
    def skin(self) -> Skin:
        """All patches, for `Reconstructor`; raises InputError where the robot has none."""
        if not self.patches:
            raise InputError(
                f"robot {self.name!r} has no skin, expected patches on its links: load it with "
                "load_robot(path, skin={link: layout})"
            )
        return Skin(self.patches, name=self.name, notes=self.notes)

    @property
    def base(self) -> str:
        """Name of the link that all poses are in."""
        children = {joint.child for joint in self.joints}
        return next(link.name for link in self.links if link.name not in children)

    @cached_property
    def joint_names(self) -> tuple[str, ...]:
        """Names of the joints that move by themselves: neither fixed nor of those that mimic."""
        own = (each for each in self.joints if each.kind != "fixed" and each.mimic is None)
        return tuple(joint.name for joint in own)

    @cached_property
    def _by_child(self) -> dict[str, Joint]:
        return {joint.child: joint for joint in self.joints}

    @cached_property
    def _drives(self) -> dict[str, tuple[str, float, float]]:
        """Of each joint that moves: the one of `joint_names` it goes by, multiplier and offset."""
        by_name = {joint.name: joint for joint in self.joints}
        found = {}
        for joint in self.joints:
            multiplier, offset, at = 1.0, 0.0, joint
            while at.mimic is not None:
                offset += multiplier * at.mimic.offset
                multiplier *= at.mimic.multiplier
                at = by_name[at.mimic.joint]
            if joint.kind != "fixed":
                found[joint.name] = (at.name, multiplier, offset)
        return found

    def link(self, name: str) -> Link:
        """Link of a name; raises InputError where there is none."""
        for link in self.links:
            if link.name == name:
                return link
        names = [each.name for each in self.links]
        raise InputError(
            f"link is {name!r}, which {self.name!r} has not, expected one of "
            f"{', '.join(names[:12])}{', ...' if len(names) > 12 else ''}{nearest(name, names)}"
        )

    def poses(self, joint_positions: JointPositions = None) -> dict[str, Floats]:
        """Pose of each link in the base: forward kinematics.

        Parameters
        ----------
        joint_positions : mapping of str to float, or (n,) array, rad or m
            See the class; default all 0. Limits are not enforced: encoders may be beyond them.

        Returns
        -------
        dict of str to (4, 4) array, m

        Raises
        ------
        InputError
            For a name that no joint has, a joint that mimics, or numbers that are not finite.
        """
        at = self._positions(joint_positions)
        found = {self.base: np.eye(4)}
        for joint in self.joints:
            move = joint.parent_from_child(at.get(joint.name, 0.0))
            found[joint.child] = np.asarray(found[joint.parent] @ move)
        return found

    def jacobian(
        self,
        link: str,
        point: ArrayLike = (0.0, 0.0, 0.0),
        joint_positions: JointPositions = None,
    ) -> Floats:
        """Geometric Jacobian of a point of a link, in the base.

        Parameters
        ----------
        link : str
        point : (3,) array, m
            In the link's frame. Default its origin.
        joint_positions
            As for `poses`.

        Returns
        -------
        (6, n) array
            Velocity of the point (3), then angular velocity of the link (3), for each of
            `joint_names`: m/rad and 1, or 1 and 0 of a prismatic joint.

        Raises
        ------
        InputError
            As `poses`; for a link that is not there, or a point that is not (3,) numbers.
        """
        self.link(link)
        place = as_floats("point", point)
        check_shape("point", place, (3,), "x, y, z in the link's frame")
        check_finite("point", place, "metres in the link's frame")
        return self._jacobian(link, place, self.poses(joint_positions))

    def _jacobian(self, link: str, point: Floats, poses: Mapping[str, Floats]) -> Floats:
        """See `jacobian`: the column of a joint is the twist that it causes (Craig, 5.6)."""
        place = poses[link][:3, :3] @ point + poses[link][:3, 3]
        found = np.zeros((6, len(self.joint_names)))
        while link in self._by_child:
            joint = self._by_child[link]
            if joint.kind != "fixed":
                driver, multiplier, _ = self._drives[joint.name]
                axis = multiplier * poses[link][:3, :3] @ joint.axis  # which the motion leaves
                column = found[:, self.joint_names.index(driver)]
                if joint.kind == "prismatic":
                    column[:3] += axis
                else:
                    column[:3] += np.cross(axis, place - poses[link][:3, 3])
                    column[3:] += axis
            link = joint.parent
        return found

    def joint_torques(
        self, wrenches: Mapping[str, ArrayLike], joint_positions: JointPositions = None
    ) -> Floats:
        """Joint torques that contacts cause, by virtual work: the sum of Jᵀ w.

        A controller that measures torques subtracts them to see what contacts do not explain.

        Parameters
        ----------
        wrenches : mapping from names of links to (6,) array, N and N m
            Such as `Snapshot.wrenches`: force on the link and moment about the link's origin, in
            the link's frame.
        joint_positions
            As for `poses`.

        Returns
        -------
        (n,) array, N m
            In the order of `joint_names`, in the direction of positive positions; N of prismatic
            joints.

        Raises
        ------
        InputError
            As `poses`; for a link that is not there, or a wrench that is not (6,) finite numbers.
        """
        poses = self.poses(joint_positions)
        torques = np.zeros(len(self.joint_names))
        for link, given in wrenches.items():
            self.link(link)
            name = f"wrenches[{link!r}]"
            wrench = as_floats(name, given)
            check_shape(name, wrench, (6,), "force and moment about the link's origin")
            check_finite(name, wrench, "newtons and newton metres")
            turned = (poses[link][:3, :3] @ wrench.reshape(2, 3).T).T.ravel()
            torques += self._jacobian(link, np.zeros(3), poses).T @ turned
        return torques

    def in_base(
        self, contacts: Iterable[Contact], joint_positions: JointPositions = None
    ) -> tuple[Contact, ...]:
        """Contacts in the frame of the base, at joint positions as for `poses`.

        Parameters
        ----------
        contacts : iterable of Contact
            On links of this robot, each in its link's frame, as those on `skin` are.

        Raises
        ------
        InputError
            As `poses`; for a contact whose link the robot does not have.
        """
        poses = self.poses(joint_positions)
        return tuple(contact.moved(poses[self.link(contact.link).name]) for contact in contacts)

    def skin_distance(self) -> dict[str, Floats]:
        """Distance of each taxel from the meshes of its link, by the names of patches, (L,) m.

        Taxels of a layout that is on the right link, in its frame, are within a millimetre or two
        of its mesh. Needs trimesh, the extra `skinfield[mesh]`.

        Raises
        ------
        InputError
            If a link with skin has no mesh, a mesh cannot be read, or trimesh is missing.
        """
        return {patch.name: self.link(patch.link).distance(patch.positions) for patch in self.skin}

    def _positions(self, given: JointPositions) -> dict[str, float]:
        """Position of each joint that moves."""
        own = self.joint_names
        if given is None:
            values = dict.fromkeys(own, 0.0)
        elif isinstance(given, Mapping):
            for name in given:
                if name not in own:
                    self._refuse(str(name))
            column = as_floats("joint_positions", list(given.values()))
            check_shape("joint_positions", column, (len(given),), "one number for each joint")
            values = dict.fromkeys(own, 0.0) | dict(zip(given, column.tolist(), strict=True))
        else:
            column = as_floats("joint_positions", given)
            check_shape("joint_positions", column, (len(own),), "one for each of joint_names")
            values = dict(zip(own, column.tolist(), strict=True))
        check_finite("joint_positions", np.array([*values.values()]), "rad, or m of prismatic ones")
        return {
            name: multiplier * values[driver] + offset
            for name, (driver, multiplier, offset) in self._drives.items()
        }

    def _refuse(self, name: str) -> None:
        for joint in self.joints:
            if joint.name == name:
                why = f"mimics {joint.mimic.joint!r}" if joint.mimic else "is fixed"
                raise InputError(
                    f"joint_positions names {name!r}, which {why}, expected joints that move by "
                    "themselves: leave it out"
                )
        raise InputError(
            f"joint_positions names {name!r}, which no joint of {self.name!r} has, expected one of "
            f"{', '.join(self.joint_names[:12])}"
            f"{', ...' if len(self.joint_names) > 12 else ''}{nearest(name, self.joint_names)}"
        )


def distance_from_triangles(triangles: Floats, points: Floats) -> Floats:
    """Distance of points (N, 3) from the nearest of triangles (T, 3, 3), (N,)."""
    with needs("trimesh", "skinfield[mesh]", "meshes"):
        from trimesh.triangles import closest_point

    centres = triangles.mean(axis=1)
    radii = np.linalg.norm(triangles - centres[:, None], axis=2).max(axis=1)
    found = np.empty(len(points))
    for first in range(0, len(points), TOGETHER):
        some = points[first : first + TOGETHER]
        apart = np.linalg.norm(some[:, None] - centres, axis=2)
        row, triangle = np.nonzero(apart - radii <= apart.min(axis=1)[:, None])
        close: Any = closest_point(triangles[triangle], some[row])  # type: ignore[no-untyped-call]
        distance = np.full(len(some), np.inf)
        np.minimum.at(distance, row, np.linalg.norm(close - some[row], axis=1))
        found[first : first + TOGETHER] = distance
    return found
