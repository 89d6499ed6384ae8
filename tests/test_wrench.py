"""Wrenches: their sums, another origin, and how often their covariance holds what is drawn."""

import numpy as np
import pytest

from skinfield.estimate import Contact, Wrench
from skinfield.estimate.wrench import SHEAR_STD, wrenches_by_link
from skinfield.solve.atoms import fit_kernel


def contact(place: list[float], normal: list[float], force: float) -> Contact:
    own = np.array(normal) / np.linalg.norm(normal)
    known = np.diag([0.5e-3, 0.8e-3, 0.05 * force]) ** 2
    known[0, 2] = known[2, 0] = 0.5 * 0.5e-3 * 0.05 * force
    names = ("area", "peak_pressure", "area_std", "radius", "angle")
    return Contact(
        position=np.array(place), force=-force * own, moment=np.zeros(3), normal=own,
        covariance=known, shape="other", outline=np.empty((0, 3)), axes=np.zeros(2),
        cells=np.empty(0, np.int64), link="arm", **dict.fromkeys(names, 0.0),
    )  # fmt: skip


CONTACTS = [contact([0.1, 0.0, 0.03], [0, 0, 1], 2.0), contact([0.0, 0.05, 0.1], [1, 2, 0], 3.0)]


def test_sums_about_two_points() -> None:
    wrench = Wrench.of(CONTACTS, stamp_ns=7)
    np.testing.assert_allclose(wrench[:3], sum(each.force for each in CONTACTS))
    for shift in (np.zeros(3), np.array([0.2, -0.1, 0.3])):
        pose = np.eye(4)
        pose[:3, 3] = -shift
        about = sum(np.cross(each.position - shift, each.force) for each in CONTACTS)
        np.testing.assert_allclose(wrench.moved(pose).moment, about, atol=1e-15)
        moved = Wrench.of([each.moved(pose) for each in CONTACTS])
        np.testing.assert_allclose(wrench.moved(pose).covariance, moved.covariance, atol=1e-12)
    assert wrench.stamp_ns == 7
    centre = 0.4 * CONTACTS[0].position + 0.6 * CONTACTS[1].position
    np.testing.assert_allclose(np.asarray(wrench.centre_of_pressure), centre)
    assert Wrench.of([]).centre_of_pressure is None


def test_intervals_hold_what_is_drawn() -> None:
    assert fit_kernel.SHEAR_STD == SHEAR_STD
    wrench, rng, draws = Wrench.of(CONTACTS), np.random.default_rng(5), 4000
    found = np.zeros((draws, 6))
    for each in CONTACTS:
        moves = rng.multivariate_normal(np.zeros(3), each.covariance, draws)
        places = each.position + moves[:, :2] @ each.tangents.T
        shear = rng.normal(size=(draws, 2)) * SHEAR_STD * each.normal_force
        forces = each.force - moves[:, 2:] * each.normal + shear @ each.tangents.T
        found += np.hstack([forces, np.cross(places, forces)])
    inside = np.abs(found - wrench.values) < 1.645 * np.sqrt(np.diag(wrench.covariance))
    share = inside.mean(axis=0)
    assert (share > 0.87).all()
    assert (share < 0.93).all()


def test_patches_on_no_link_have_no_common_wrench_and_none_changes_in_place() -> None:
    wrench = Wrench.of([contact([1.0, 0.0, 0.0], [0.0, 0.0, 1.0], 2.0)], np.eye(4), 1)
    by_link = wrenches_by_link([("", wrench), ("arm", wrench), ("arm", wrench), ("", wrench)])
    assert list(by_link) == ["arm"]
    np.testing.assert_allclose(by_link["arm"], 2.0 * wrench)
    with pytest.raises(TypeError):
        wrench += 1.0
