"""The virtual rig against single presses, closed forms and its own statements."""

from dataclasses import replace

import numpy as np
import pytest

import skinfield as sf
from skinfield.elastic import StandardLinearSolid
from skinfield.errors import InputError
from skinfield.simulate.electronics import Delivery, Electronics, LinearBoard, icub_electronics
from skinfield.simulate.rig import (
    At,
    BetweenThree,
    BetweenTwo,
    ContactAccuracy,
    LoadCell,
    LoadProfile,
    Loads,
    OverTaxels,
    Pose,
    Random,
    Raster,
    RigRun,
    Scenario,
    Tool,
    run_rig,
)
from skinfield.simulate.rig.run import solve_ladder
from skinfield.skin.generators import icub_triangle

BALL = sf.simulate.Sphere(radius=6e-3)
IDEAL = Electronics(board=LinearBoard(), quantised=False, delivery=Delivery(rate=50.0))
COARSE = ContactAccuracy(
    extent=16e-3, cell=0.6e-3, rungs=4
)  # where the elastic solution does not matter
ELASTIC = StandardLinearSolid(relaxed_fraction=1.0)
SMALL = Scenario(
    patch=icub_triangle(),
    loads=Loads(forces=(1.0,)),
    electronics=IDEAL,
    elastomer=ELASTIC,
    solving=ContactAccuracy(extent=16e-3, rungs=4),
)


@pytest.fixture(scope="module")
def creeping() -> RigRun:
    """Three presses at one place and two at another, with creep."""
    return run_rig(
        replace(
            SMALL,
            places=(OverTaxels(taxels=(3,), angle=0.3), At(positions=((2e-3, 1e-3),))),
            loads=Loads(forces=(0.5, 1.0)),
            elastomer=StandardLinearSolid(relaxed_fraction=0.6, time_constant=1.5),
            load_cell=LoadCell(full_scale=0.8, noise=2e-3, offset=0.05, delay=0.02),
        )
    )


def direct(pose: Pose, force: float, patch: sf.Patch) -> np.ndarray:
    """ΔC/C₀ of one press, with the indenter moved and not the taxels."""
    body = replace(BALL, position=(pose.x, pose.y), rotation=pose.angle, force=force)
    pressed = sf.simulate.press(sf.Layer(), [body], extent=24e-3)
    return pressed.capacitance(patch.plane, patch.pad_diameter)


def test_readings_under_a_standing_load_are_those_of_a_press_at_that_place() -> None:
    pose = Pose(1.3e-3, -2.1e-3, 0.7)
    run = run_rig(replace(SMALL, places=(At(positions=((pose.x, pose.y),), angle=pose.angle),)))
    reference = direct(pose, 1.0, run.scenario.patch)
    truth = run.truth
    held = (truth.reading_time_s > truth.press_hold_s[0]) & (
        truth.reading_time_s < truth.press_release_s[0]
    )
    error = np.abs(run.recording.counts[held] - reference).max()
    assert 0 < error < 2e-3 * np.abs(reference).max()  # two grids, one truth
    untouched = truth.reading_time_s < truth.press_touch_s[0]
    assert np.abs(run.recording.counts[untouched]).max() == 0.0


@pytest.mark.parametrize(
    "body", [BALL, sf.simulate.Cylinder(radius=1.5e-3)], ids=lambda body: body.kind
)
def test_between_rungs_readings_are_interpolated_to_half_a_percent(body: object) -> None:
    scenario = replace(SMALL, solving=ContactAccuracy(extent=12e-3, rungs=12))
    poses = [Pose(0.0, 0.0), Pose(4e-3, 0.0, 1.0)]
    ladder = solve_ladder(scenario, body, poses)  # type: ignore[arg-type]
    between = np.array([0.02, 0.37, 0.8])
    found = np.stack([
        ladder.change_at(pose, between[:, None], np.zeros(12, np.int64)) for pose in (0, 1)
    ], axis=1)  # fmt: skip
    exact = sf.simulate.press_ladder(sf.Layer(), body, between, extent=12e-3)
    plane, pad = scenario.patch.plane, scenario.patch.pad_diameter
    peak = np.abs(ladder.change[-1]).max()
    seen = np.concatenate([pose.taxels(plane) for pose in poses])
    for row, press in enumerate(exact):
        error = found[row].ravel() - press.capacitance(seen, pad)
        assert np.abs(error).max() < 5e-3 * peak
    depth = [press.approach[0] for press in exact]
    assert ladder.depth_at(between) == pytest.approx(depth, rel=0.02)
    assert ladder.force_at(ladder.depth_at(between)) == pytest.approx(between, rel=2e-3)


def test_a_rig_that_pushes_aside_presses_at_a_slant() -> None:
    """Half the force to the side: as the press itself, also of an indenter that is turned."""
    loads = Loads(forces=(0.5,), shear_part=(0.0, 0.5), friction=0.5)
    scenario = replace(SMALL, loads=loads, solving=COARSE)
    ladder = solve_ladder(scenario, BALL, [Pose(0.0, 0.0), Pose(0.0, 0.0, np.pi)])
    (load,) = ladder.loads
    np.testing.assert_allclose(load.shears, [[0.0, 0.25]], rtol=1e-4, atol=1e-6)
    assert load.slipping_share == 1.0
    body = replace(BALL, force=0.5, shear=(0.0, 0.25))
    alone = sf.simulate.press(scenario.true_layer, [body], 16e-3, 0.6e-3, friction=0.5)
    plane, pad = scenario.true_plane, scenario.patch.pad_diameter
    np.testing.assert_allclose(ladder.change[-1, 0], alone.capacitance(plane, pad), atol=1e-6)
    back = alone.capacitance(-plane, pad)
    np.testing.assert_allclose(ladder.change[-1, 1], back, atol=1e-6)
    assert np.abs(ladder.change[-1, 0] - back).max() > 0.1 * np.abs(back).max()
    with pytest.raises(InputError, match="beside depths, expected forces"):
        Loads(depths=(1e-4,), shear_part=(0.5, 0.0))


def test_forces_follow_the_profile_and_pressures_sum_to_them(creeping: RigRun) -> None:
    truth = creeping.truth
    assert truth.press_force_N == pytest.approx([0.5, 1.0, 0.5, 1.0], rel=1e-9)
    assert truth.load_force_N == pytest.approx([0.5, 1.0], rel=1e-6)
    assert truth.pressure_Pa.sum(axis=1) * truth.cell_m**2 == pytest.approx([0.5, 1.0], rel=1e-3)
    for row in range(4):
        inside = (truth.time_s > truth.press_touch_s[row]) & (truth.time_s < truth.press_end_s[row])
        impulse = truth.force_N[inside].sum() * 2e-3
        assert impulse == pytest.approx(truth.press_force_N[row] * 2.5, rel=1e-3)  # hold and ramps
    assert not truth.force_N[truth.press == -1].any()
    assert truth.contact_area_m2[truth.force_N == 0].max() == 0.0


def test_what_is_left_of_a_load_fades_with_its_field(creeping: RigRun) -> None:
    """Whatever touched: as a little of all its pressure, to which readings are proportional."""
    truth, pose = creeping.truth, creeping.scenario.poses[0]
    gone = truth.press_end_s[0] + 0.05, truth.press_touch_s[1]
    after = (truth.reading_time_s > gone[0]) & (truth.reading_time_s < gone[1])
    effective = np.interp(truth.reading_time_s[after], truth.time_s, truth.effective_force_N)
    body = replace(BALL, position=(pose.x, pose.y), rotation=pose.angle, force=0.5)
    pressed = sf.simulate.press(sf.Layer(), [body], extent=24e-3)
    part = [replace(each, traction=0.1 * each.traction) for each in pressed.touches]
    patch = creeping.scenario.patch
    field = replace(pressed, touches=tuple(part)).capacitance(patch.plane, patch.pad_diameter)
    left, expected = truth.reading_change[after], effective[:, None] * field / 0.05
    assert after.sum() > 10
    assert effective.min() > 0.05
    assert left == pytest.approx(expected, abs=0.03 * expected.max())


def test_creep_is_that_of_the_solid(creeping: RigRun) -> None:
    """A held load acts as E∞ J(t) of itself; the ramp only blurs its start."""
    truth, solid = creeping.truth, creeping.scenario.elastomer
    middle = truth.press_touch_s[0] + 0.25

    def creep(since: float) -> float:
        return 1.0 - (1.0 - solid.relaxed_fraction) * np.exp(-since / solid.retardation_time)

    late = truth.press_release_s[0] - middle
    expected = 0.5 * creep(late)
    assert truth.press_effective_force_N[0] == pytest.approx(expected, rel=0.01)
    again = truth.press_effective_force_N[1] - creep(late)
    faded = 0.5 * (creep(late + 4.0) - creep(late + 4.0 - 2.5))
    assert again == pytest.approx(faded, rel=0.03)  # what is left of the first press


def test_depth_control_reaches_the_depth_and_relaxes() -> None:
    solid = StandardLinearSolid(relaxed_fraction=0.7, time_constant=0.5)
    run = run_rig(replace(SMALL, loads=Loads(depths=(0.4e-3,)), elastomer=solid))
    truth = run.truth
    assert truth.press_depth_m == pytest.approx([0.4e-3], rel=2e-3)
    ball = replace(BALL, force=None, depth=0.4e-3)
    relaxed = sf.simulate.press(sf.Layer(), [ball], extent=16e-3).force
    assert truth.load_force_N[0] == pytest.approx(relaxed)
    assert truth.press_force_N[0] == pytest.approx(relaxed, rel=0.02)  # after 4 time constants
    assert 1.05 * relaxed < truth.force_N.max() < relaxed / 0.7
    assert truth.force_N.min() == 0.0
    assert truth.height_m.min() == pytest.approx(-0.4e-3, rel=1e-9)


def test_the_load_cell_errs_as_it_says(creeping: RigRun) -> None:
    truth, cell = creeping.truth, creeping.load_cell
    true = np.interp(cell.stamp_ns * 1e-9 - 0.02, truth.time_s, truth.force_N)
    error = (cell.force - true)[~cell.saturated]
    assert error.mean() == pytest.approx(0.05, abs=5e-4)
    assert error.std() == pytest.approx(2e-3, rel=0.1)
    assert (cell.force[cell.saturated] == 0.8).all()
    assert cell.saturated[true > 0.77].all()
    assert not cell.saturated[true < 0.73].any()
    assert np.median(np.diff(cell.stamp_ns)) == pytest.approx(1e7, rel=1e-3)
    steps = LoadCell(resolution=0.01, noise=0.0).measure(
        np.array([0.0, 1.0]), np.array([0.0, 1.0]), np.random.default_rng(0)
    )
    assert np.abs(steps.force / 0.01 - np.rint(steps.force / 0.01)).max() < 1e-9


def test_seeds_make_the_same_run_and_others_do_not(monkeypatch: pytest.MonkeyPatch) -> None:
    noisy = replace(
        SMALL, electronics=icub_electronics(), places=(Random(count=2),), repeats=2, solving=COARSE
    )
    one, other = (scenario for _, scenario in noisy.runs())
    ladder = solve_ladder(one, one.tools[0].indenter, one.poses)  # all runs have these places
    monkeypatch.setattr("skinfield.simulate.rig.run.solve_ladder", lambda *_: ladder)
    first, second = run_rig(one), run_rig(other)
    again = run_rig(first.scenario)
    assert np.array_equal(first.recording.counts, again.recording.counts, equal_nan=True)
    assert np.array_equal(first.load_cell.force, again.load_cell.force)
    assert not np.array_equal(first.load_cell.force, second.load_cell.force)
    assert np.array_equal(first.skin.gain, second.skin.gain)  # the same skin
    assert np.array_equal(first.truth.press_x_m, second.truth.press_x_m)  # the same places
    assert replace(first.scenario, seed=1).poses != first.scenario.poses


def test_a_recording_is_as_from_a_board() -> None:
    board = replace(SMALL, electronics=icub_electronics(), loads=Loads(forces=(2.0,)))
    run = run_rig(replace(board, solving=COARSE))
    recording = run.recording
    assert recording.unit == "count"
    assert recording.uid is not None
    assert recording.uid.tolist() == run.scenario.patch.uid.tolist()
    assert recording.counts.min() >= 0
    assert recording.counts.max() <= 255
    assert recording.rate == pytest.approx(20.0, rel=0.01)
    # What a calibration finds in it is the truth, within the noise of one reading.
    change = run.skin.calibration.relative_capacitance_from_counts(recording.counts)
    error = (change - run.truth.reading_change) / run.skin.calibration.quantity_std()
    assert 0.9 < error.std() < 1.3


@pytest.mark.parametrize("smooth", [True, False])
def test_profiles_have_their_parts(smooth: bool) -> None:
    profile = LoadProfile(smooth=smooth)
    assert 3.0 <= profile.period <= 5.0
    time = np.linspace(0.0, profile.period, 40_001)
    load, height = profile.load(time), profile.height(time)
    assert not (load * height).any()
    assert load[(time >= 1.0) & (time <= 3.0)] == pytest.approx(1.0)
    assert load.mean() * profile.period == pytest.approx(2.5, rel=1e-4)
    assert height[[0, -1]] == pytest.approx(5e-3)
    jumps = np.abs(np.diff(load, 2)).max() / (time[1] ** 2)
    assert (jumps < 25) == smooth  # acceleration of the quintic: 5.8 / 0.5² s²


def test_places_are_where_they_say() -> None:
    patch, rng = sf.layouts.icub_hexagon(), np.random.default_rng(0)
    plane = patch.plane
    (over,) = OverTaxels(taxels=(5,)).poses(patch, rng)
    assert (over.x, over.y) == pytest.approx(plane[5])
    (two,) = BetweenTwo().poses(patch, rng)
    (three,) = BetweenThree().poses(patch, rng)
    near = [np.sort(np.hypot(*(plane - [p.x, p.y]).T)) for p in (two, three)]
    assert near[0][0] == pytest.approx(near[0][1])
    assert near[0][0] == pytest.approx(2.5e-3, rel=1e-3)  # pads 5 mm from each other
    assert near[1][:3] == pytest.approx(5e-3 / np.sqrt(3), rel=1e-3)
    middle = plane.mean(axis=0)
    assert np.hypot(two.x - middle[0], two.y - middle[1]) < 10e-3
    drawn = Random(count=200, within=2e-3, turned=True).poses(patch, rng)
    assert max(np.hypot(*(plane - [p.x, p.y]).T).min() for p in drawn) <= 2e-3
    assert np.ptp([p.angle for p in drawn]) > 5.0
    raster = Raster(rows=2, columns=3, step=4e-3).poses(patch, rng)
    steps = np.hypot(np.diff([p.x for p in raster]), np.diff([p.y for p in raster]))
    assert steps == pytest.approx(4e-3)  # to and fro, never far


def test_a_pose_moves_taxels_the_other_way() -> None:
    pose = Pose(1.0, 2.0, np.pi / 2)
    seen = pose.taxels([[1.0, 2.0], [1.0, 3.0]])
    assert seen == pytest.approx(np.array([[0.0, 0.0], [1.0, 0.0]]))


def test_what_cannot_be_is_refused() -> None:
    with pytest.raises(InputError, match="2 tools and 1 repeats, expected one of each"):
        run_rig(replace(SMALL, tools=tuple(Tool(name=n, indenter=BALL) for n in "ab")))
    with pytest.raises(InputError, match="of different names"):
        replace(SMALL, tools=tuple(Tool(name="a", indenter=BALL) for _ in "ab"))
    with pytest.raises(InputError, match=r"name is '../x', expected"):
        Tool(name="../x", indenter=BALL)
    with pytest.raises(InputError, match=r"taxels holds \[\[99\]\], expected rows from 0 to 11"):
        run_rig(replace(SMALL, places=(OverTaxels(taxels=(99,)),)))
    with pytest.raises(InputError, match="expected one of the two"):
        Loads(forces=(1.0,), depths=(1e-3,))
    with pytest.raises(InputError, match=r"sinks|thickness"):
        run_rig(replace(SMALL, loads=Loads(forces=(90.0,))))
    with pytest.raises(InputError, match="ramp is 0"):
        LoadProfile(ramp=0.0)
    with pytest.raises(InputError, match="found 0 of 1 that near"):
        Random(count=1, within=1e-9).poses(icub_triangle(), np.random.default_rng(0))
