"""Mounting of skin on links: by the names of links, or by the nearest mesh."""

from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from skinfield.errors import InputError, check_type
from skinfield.files.layouts.load import skin_from_text
from skinfield.robot.body import Robot
from skinfield.settings import nearest
from skinfield.skin import Patch, Skin

NEAR = 10e-3  # m from a mesh, on average, of the taxels of a patch on that link
CLEAR = 0.95  # of the next link's distance, that the nearest one's is at most
SOME = 64  # taxels that are tried on each link
LAYOUT = "a Patch, a Skin, the path of a layout, the name of a generator, or a sequence of these"


def patches_on(robot: Robot, skin: Any) -> tuple[tuple[Patch, ...], tuple[str, ...]]:
    """Patches on their links, as `load_robot` says, and notes; raises InputError."""
    names = {link.name for link in robot.links}
    patches: list[Patch] = []
    notes: list[str] = []
    for part, layout in skin.items() if isinstance(skin, Mapping) else (("", skin),):
        check_type("skin", part, str, "names of links are text")
        its = list(_patches_of(layout, notes))
        for patch in its:
            link, how = (part, "") if part in names else _link_of(robot, patch, part)
            notes += [how] if how else []
            patches.append(_in_link(patch, link, patch.name))
        if part and part not in names and len(its) == 1:
            patches[-1] = replace(patches[-1], name=part)
    return _distinct(patches), tuple(notes)


def _patches_of(layout: Any, notes: list[str]) -> Iterator[Patch]:
    """Patches of what a layout may be."""
    if isinstance(layout, Patch):
        yield layout
    elif isinstance(layout, Skin):
        notes += layout.notes
        yield from layout
    elif isinstance(layout, str | Path):
        yield from _patches_of(skin_from_text(str(layout)), notes)
    elif isinstance(layout, list | tuple):
        for each in layout:
            yield from _patches_of(each, notes)
    else:
        raise InputError(f"skin holds a {type(layout).__name__}, expected {LAYOUT}")


def _in_link(patch: Patch, link: str, name: str) -> Patch:
    """The patch with its taxels in the frame of its link."""
    turn, shift = patch.link_from_patch[:3, :3], patch.link_from_patch[:3, 3]
    if np.array_equal(patch.link_from_patch, np.eye(4)):
        return replace(patch, link=link, name=name)
    return replace(
        patch,
        positions=patch.positions @ turn.T + shift,
        normals=patch.normals @ turn.T,
        link_from_patch=np.eye(4),
        link=link,
        name=name,
    )


def _distinct(patches: list[Patch]) -> tuple[Patch, ...]:
    """Patches under names that are there once: those that are not are called by their links."""
    count = Counter(patch.name for patch in patches)
    on_link = Counter(patch.link for patch in patches)
    taken, named = {name for name in count if count[name] == 1}, []
    for patch in patches:
        name = patch.name
        if count[name] > 1:
            own = patch.link if on_link[patch.link] == 1 else f"{patch.link}/{patch.name}"
            name, number = own, 1
            while name in taken:
                number += 1
                name = f"{own}-{number}"
            taken.add(name)
        named.append(patch if name == patch.name else replace(patch, name=name))
    return tuple(named)


def _link_of(robot: Robot, patch: Patch, part: str) -> tuple[str, str]:
    """Link of a patch that no link was named for, and how it was found."""
    names = [link.name for link in robot.links]
    if patch.link in names:
        return patch.link, ""
    what = f"skin part {part!r}" if part else f"patch {patch.name!r}"
    there = [link for link in robot.links if any(each.path.is_file() for each in link.meshes)]
    remedy = f"name the link, as in skin={{{names[-1]!r}: layout}}{nearest(part, names)}"
    if not there:
        raise InputError(
            f"{what} names no link of {robot.name!r}, and no mesh of it is there to go by, "
            f"expected one of {', '.join(names[:12])}{', ...' if len(names) > 12 else ''}: {remedy}"
        )
    points = _in_link(patch, "", patch.name).positions[:: -(-len(patch) // SOME)]
    apart = sorted((float(each.distance(points).mean()), each.name) for each in there)
    (least, link), (next_least, other) = (*apart, (np.inf, ""))[:2]
    far = f"{least * 1e3:.2g} mm"
    if least > NEAR:
        raise InputError(
            f"{what} names no link of {robot.name!r}, and the nearest mesh, that of {link!r}, is "
            f"{far} from its taxels, expected at most {NEAR * 1e3:g}: {remedy}"
        )
    if least > CLEAR * next_least:
        raise InputError(
            f"{what} names no link of {robot.name!r}, and the meshes of {link!r} and {other!r} are "
            f"as near, {far} from its taxels, expected one that is nearer: {remedy}"
        )
    return link, f"{what} is on {link!r}, whose mesh is nearest: {far} from its taxels"
