"""URDF reader: links, joints and meshes of a robot's description, checked line by line.

Elements are those of the URDF specification (wiki.ros.org/urdf/XML); inertia, collision shapes,
materials, transmissions, sensors and extensions of simulators are not read.
"""

import math
from collections.abc import Iterable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any, get_args
from xml.etree.ElementTree import Element

import numpy as np

from skinfield.errors import FileError, Floats
from skinfield.robot.body import Joint, Kind, Link, Mesh, Mimic, Robot, rotation
from skinfield.settings import nearest
from skinfield.wire.icub.robot_files import WHERE, read_tree, spoilt

LARGEST = 1 << 24  # bytes; that of a humanoid has 0.1 to 1 MB
KINDS = get_args(Kind)
MOST = 10_000  # links


def load_robot(path: str | Path, skin: Any = None) -> Robot:
    """Read a robot from URDF, with skin on its links.

    Parameters
    ----------
    path : str or Path
        Of the URDF; xacro has to be run on .xacro files before. Meshes ``package://name/file`` are
        looked for in the folder `name` above or beside the file, where it is.
    skin : mapping from names of links to layouts, or a layout, optional
        A layout is a `Patch`, a `Skin`, the path of any layout file or folder that `load_layout`
        reads, a generator by name, or a sequence of these. It is in the link's frame, moved by
        `link_from_patch` where a patch has it. A name that is none of a link is that of a part:
        its patches, and those of a layout without a name, go to the link that the layout names, or
        to that with the nearest mesh (needs trimesh, the extra `skinfield[mesh]`).

    Returns
    -------
    Robot
        ``robot.skin`` is for `Reconstructor`. Its contacts are in the frames of the links.

    Raises
    ------
    FileError
        If a file cannot be read or is no such file; the message names the line. So are joints of
        another type than revolute, continuous, prismatic and fixed, links with two parents,
        circles, and joints of links that are not there.
    InputError
        If a layout is none, or no link is near to it.
    """
    from skinfield.robot.mounting import patches_on

    robot = read_urdf(Path(path))
    if skin is None:
        return robot
    patches, notes = patches_on(robot, skin)
    return replace(robot, patches=patches, notes=notes)


def read_urdf(path: Path) -> Robot:
    """Robot without skin; raises as `load_robot`."""
    root = read_tree(path, LARGEST)
    if root.tag != "robot":
        raise FileError(
            f"{root.get(WHERE)}: the outermost element is <{root.tag}>, expected <robot> of a "
            "URDF; SDF and MJCF are not read: convert it to URDF"
        )
    for node in root.iter():
        if isinstance(node.tag, str) and node.tag.startswith("xacro:"):
            raise FileError(
                f"{node.get(WHERE)}: <{node.tag}> is xacro, expected plain URDF: run "
                "`xacro robot.urdf.xacro > robot.urdf`, and read that"
            )
    links, joints = _by_name(root, "link"), _by_name(root, "joint")
    if not links:
        raise FileError(f"{root.get(WHERE)}: the robot has no <link>, expected one or more")
    if len(links) > MOST:
        raise FileError(f"{path}: {len(links)} links, expected at most {MOST}")
    read = {name: _joint(node, links) for name, node in joints.items()}
    _check_mimics(read, joints)
    return Robot(
        name=root.get("name") or path.stem,
        links=tuple(Link(name=n, meshes=_meshes(node, path)) for n, node in links.items()),
        joints=_outwards(root, links, read, joints),
    )


def _by_name(root: Element, tag: str) -> dict[str, Element]:
    """Elements directly within the robot, by their names, each of which is there once."""
    found: dict[str, Element] = {}
    for node in root.findall(tag):
        name = _attribute(node, "name", "that nothing else of its kind has")
        if name in found:
            raise FileError(
                f"{node.get(WHERE)}: <{tag}> {name!r} is there already, at "
                f"{found[name].get(WHERE)}, expected each name once: rename one"
            )
        found[name] = node
    return found


def _attribute(node: Element, name: str, what: str) -> str:
    value = node.get(name)
    if not value:
        raise FileError(f"{node.get(WHERE)}: <{node.tag}> has no {name}, expected one {what}")
    return value


def _child(node: Element, tag: str, why: str) -> Element:
    found = node.find(tag)
    if found is None:
        raise FileError(
            f"{node.get(WHERE)}: {node.tag} {node.get('name')!r} has no <{tag}>, expected one: "
            f"{why}"
        )
    return found


def _number(node: Element, name: str, default: float | None = None) -> float:
    text = node.get(name)
    if text is None and default is not None:
        return default
    return _numbers(node, name, text or "", 1)[0]


def _numbers(node: Element, name: str, text: str, count: int) -> list[float]:
    """So many finite numbers of an attribute."""
    try:
        found = [float(word) for word in text.split()] if len(text) < 1000 else []
    except ValueError:
        found = []
    if len(found) != count or not all(map(math.isfinite, found)):
        what = "a finite number" if count == 1 else f"{count} finite numbers such as 0 0 1"
        raise spoilt(node, text, f"{what} as its {name}")
    return found


def _joint(node: Element, links: Mapping[str, Element]) -> Joint:
    kind = _attribute(node, "type", f"of {', '.join(KINDS)}")
    if kind not in KINDS:
        raise spoilt(
            node, kind, f"a type of {', '.join(KINDS)}: replace others by several joints of these"
        )
    ends = []
    for tag in ("parent", "child"):
        end = _child(node, tag, "a joint is between two links")
        name = _attribute(end, "link", "that is in the file")
        if name not in links:
            raise spoilt(end, name, f"the name of a <link> of the file{nearest(name, links)}")
        ends.append(name)
    turns = node.find("axis") if kind != "fixed" else None
    axis = _vector(turns, "xyz", (1.0, 0.0, 0.0))
    length = float(np.linalg.norm(axis))
    if turns is not None and not 1e-9 < length < 1e9:
        raise spoilt(turns, turns.get("xyz", ""), "a direction, not 0 0 0")
    mimic = node.find("mimic")
    return Joint(
        name=str(node.get("name")),
        kind=kind,  # type: ignore[arg-type]
        parent=ends[0],
        child=ends[1],
        parent_from_joint=_pose(node),
        axis=axis / length,
        limits=_limits(node) if kind in ("revolute", "prismatic") else None,
        mimic=None if mimic is None else _mimic(mimic),
    )


def _limits(node: Element) -> tuple[float, float]:
    limit = _child(node, "limit", "revolute and prismatic joints have them; else continuous")
    low, high = _number(limit, "lower", 0.0), _number(limit, "upper", 0.0)
    if low > high:
        raise spoilt(limit, f"lower {low:g}, upper {high:g}", "lower at most as large as upper")
    return low, high


def _mimic(node: Element) -> Mimic:
    name = _attribute(node, "joint", "that it follows")
    multiplier = _number(node, "multiplier", 1.0)
    return Mimic(joint=name, multiplier=multiplier, offset=_number(node, "offset", 0.0))


def _check_mimics(joints: Mapping[str, Joint], nodes: Mapping[str, Element]) -> None:
    """Raise FileError unless each joint that mimics comes, in the end, to one that moves."""
    for name, joint in joints.items():
        passed, at = {name}, joint
        while at.mimic is not None:
            other = at.mimic.joint
            if other not in joints or joints[other].kind == "fixed" or other in passed:
                raise spoilt(
                    _child(nodes[at.name], "mimic", ""),
                    other,
                    "a joint that moves, and does not follow this one" + nearest(other, joints),
                )
            passed.add(other)
            at = joints[other]


def _outwards(
    root: Element,
    links: Mapping[str, Element],
    joints: Mapping[str, Joint],
    nodes: Mapping[str, Element],
) -> tuple[Joint, ...]:
    """Joints from the base outwards; raises FileError unless they make one tree."""
    above: dict[str, Joint] = {}
    below: dict[str, list[Joint]] = {name: [] for name in links}
    for name, joint in joints.items():
        if joint.child in above:
            raise FileError(
                f"{nodes[name].get(WHERE)}: joint {name!r} is the second parent of link "
                f"{joint.child!r}, after {above[joint.child].name!r}, expected one: a robot is a "
                "tree; leave one out of what closes a loop"
            )
        above[joint.child] = joint
        below[joint.parent].append(joint)
    bases = [name for name in links if name not in above]
    if len(bases) != 1:
        text = f"{', '.join(bases[:8])} have no parent" if bases else "every link has a parent"
        raise FileError(
            f"{root.get(WHERE)}: {text}, expected exactly one link without, the base: "
            + ("join the others to it by fixed joints" if bases else "its joints make a circle")
        )
    ordered: list[Joint] = []
    ready = list(bases)
    for link in ready:  # which grows
        ordered += below[link]
        ready += [joint.child for joint in below[link]]
    lost = [name for name in links if name not in set(ready)]
    if lost:
        joint = above[lost[0]]
        raise FileError(
            f"{nodes[joint.name].get(WHERE)}: joint {joint.name!r} is part of a circle of "
            f"{', '.join(lost[:8])}, expected a tree that begins at {bases[0]!r}"
        )
    return tuple(ordered)


def _meshes(link: Element, path: Path) -> tuple[Mesh, ...]:
    found = []
    for visual in link.findall("visual"):
        mesh = visual.find("geometry/mesh")
        if mesh is None:
            continue
        name = _attribute(mesh, "filename", "of a mesh")
        scale = _vector(mesh, "scale", (1.0, 1.0, 1.0))
        found.append(Mesh(path=_file(name, path), link_from_mesh=_pose(visual), scale=scale))
    return tuple(found)


def _file(name: str, path: Path) -> Path:
    """Where a mesh is: beside the URDF, or in the package's folder above or beside it."""
    scheme, found, rest = name.partition("://")
    if not found:
        return path.parent / name
    if scheme == "file":
        return Path(rest)
    package, _, file = rest.partition("/")
    for folder in path.absolute().parents:
        if folder.name == package and (folder / file).exists():
            return folder / file
        if (folder / package / file).exists():
            return folder / package / file
    return path.parent / file


def _pose(node: Element) -> Floats:
    """Pose (4, 4) of the `origin` of an element; rpy are turns about the fixed x, y and z."""
    origin = node.find("origin")
    pose = np.eye(4)
    pose[:3, 3] = _vector(origin, "xyz", (0.0, 0.0, 0.0))
    roll, pitch, yaw = _vector(origin, "rpy", (0.0, 0.0, 0.0)).tolist()
    x, y, z = np.eye(3)
    pose[:3, :3] = rotation(yaw, z) @ rotation(pitch, y) @ rotation(roll, x)
    return pose


def _vector(node: Element | None, name: str, default: Iterable[float]) -> Floats:
    text = None if node is None else node.get(name)
    if node is None or text is None:
        return np.array([*default])
    return np.array(_numbers(node, name, text, 3))
