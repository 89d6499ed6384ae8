"""One recording on the rig, from the programme to counts, with its truth beside it."""

import zlib
from dataclasses import dataclass

import numpy as np

from skinfield.errors import Floats, InputError, Ints
from skinfield.reading import Recording
from skinfield.simulate.electronics import TaxelArray, recording
from skinfield.simulate.electronics.delivery import Sampling
from skinfield.simulate.pressing.press import Press
from skinfield.simulate.rig.ladder import Ladder, press_with, solve_ladder
from skinfield.simulate.rig.load_cell import LoadSeries
from skinfield.simulate.rig.motion import Pressed, Programme, pressed, programme
from skinfield.simulate.rig.scenario import Scenario
from skinfield.simulate.rig.truth import Truth

SAME = 1e-4  # forces that differ by less, relative to each other, have one field


@dataclass(frozen=True, eq=False)
class RigRun:
    """What a rig leaves.

    Attributes
    ----------
    scenario : Scenario
        Of this recording alone: it makes the same one again.
    recording : Recording
        Counts by uid, as from a board.
    load_cell : LoadSeries
    skin : TaxelArray
        The skin's electronics; `skin.calibration` is the true one.
    truth : Truth
    """

    scenario: Scenario
    recording: Recording
    load_cell: LoadSeries
    skin: TaxelArray
    truth: Truth


def run_rig(scenario: Scenario) -> RigRun:
    """Make the one recording of a scenario with one tool and one repeat.

    Raises
    ------
    InputError
        If the scenario has several recordings (`Scenario.runs` splits it), a load pushes the
        indenter through the layer, or a place is none of the patch's.
    """
    if len(scenario.tools) != 1 or scenario.repeats != 1:
        raise InputError(
            f"scenario {scenario.name!r} has {len(scenario.tools)} tools and {scenario.repeats} "
            "repeats, expected one of each: run those of scenario.runs()"
        )
    tool = scenario.tools[0]
    skin = scenario.electronics.manufacture(scenario.patch, scenario.random(0))
    plan = programme(scenario.poses, scenario.loads, scenario.profile)
    ladder = solve_ladder(scenario, tool.indenter, plan.poses)
    chance = scenario.random(2, zlib.crc32(tool.name.encode()), scenario.first_repeat)
    clock, noise, cell = chance.spawn(3)
    time = plan.time
    sampling = skin.sample_times(float(time[-1]), clock)
    series, change = _felt(scenario, plan, ladder, sampling)
    sent = recording(
        skin,
        sampling,
        change,
        _warmth(scenario, sampling.time / time[-1]),
        noise,
        source=f"virtual rig {scenario.name}, {tool.name}",
    )
    load_cell = scenario.load_cell.measure(time, series.force, cell)
    rows = sampling.logged[0]
    truth = _truth(scenario, plan, ladder, series, sampling.time[rows], change[rows])
    return RigRun(scenario, sent, load_cell, skin, truth)


def _warmth(scenario: Scenario, part: Floats) -> Floats:
    """Temperature at parts of the recording, K."""
    warm = scenario.temperature
    return np.asarray(warm.start + (warm.end - warm.start) * np.clip(part, 0.0, 1.0))


@dataclass(frozen=True, eq=False)
class Series:
    """Force and effective force of the pose that is pressed, and the press under way, (S,)."""

    time: Floats
    force: Floats
    effective: Floats
    press: Ints


def _felt(
    scenario: Scenario, plan: Programme, ladder: Ladder, sampling: Sampling
) -> tuple[Series, Floats]:
    """What happens over time, and ΔC/C₀ (T, L) of the taxels when they are converted."""
    time = plan.time
    press = plan.under_way(time)
    series = Series(time, np.zeros(len(time)), np.zeros(len(time)), press)
    skews, column = np.unique(sampling.skew, return_inverse=True)
    change = np.zeros((len(sampling), len(sampling.skew)))
    last_pressed = plan.pose[np.maximum.accumulate(press)]
    before = np.cumsum(press >= 0) == 0
    for part in pressed(plan, scenario.loads, ladder, scenario.elastomer):
        own = part.window
        series.force[own] += part.force
        mine = (last_pressed[own] == part.pose) & ~before[own]
        series.effective[own] = np.where(mine, part.effective, series.effective[own])
        rows = slice(*np.searchsorted(sampling.time, [time[own][0] - skews[-1], time[own][-1]]))
        force = _at(part, time, sampling.time[rows, None] + skews)
        change[rows] += ladder.change_at(part.pose, force, column.astype(np.int64))
    return series, change


def _at(part: Pressed, time: Floats, instants: Floats) -> Floats:
    """Effective force at instants (T, S), N."""
    return np.interp(instants, time[part.window], part.effective, left=0.0, right=0.0)


def _truth(
    scenario: Scenario,
    plan: Programme,
    ladder: Ladder,
    series: Series,
    reading_time: Floats,
    change: Floats,
) -> Truth:
    profile, time, start = scenario.profile, series.time, plan.start
    depth = ladder.depth_at(series.effective)
    area = np.where(series.force > 0, ladder.area_at(series.effective), 0.0)
    hold_end = start + profile.approach + profile.ramp + profile.hold
    at_end = np.minimum(np.rint(hold_end / time[1]).astype(np.int64), len(time) - 1)
    effective = series.effective[at_end]
    reached = np.array([effective[plan.load == load].max() for load in range(len(scenario.loads))])
    pose = [plan.poses[row] for row in plan.pose]
    return Truth(
        time_s=time,
        force_N=series.force,
        effective_force_N=series.effective,
        depth_m=depth,
        height_m=_height(scenario, plan, series, depth),
        contact_area_m2=area,
        press=series.press,
        press_x_m=np.array([p.x for p in pose]),
        press_y_m=np.array([p.y for p in pose]),
        press_angle_rad=np.array([p.angle for p in pose]),
        press_load=plan.load,
        press_start_s=start,
        press_touch_s=start + profile.approach,
        press_hold_s=start + profile.approach + profile.ramp,
        press_release_s=hold_end,
        press_end_s=hold_end + profile.release,
        press_force_N=series.force[at_end],
        press_effective_force_N=effective,
        press_depth_m=depth[at_end],
        press_area_m2=area[at_end],
        load_force_N=np.array([found.force for found in ladder.loads]),
        load_effective_force_N=reached,
        plane_m=ladder.loads[0].grid.plane,
        cell_m=ladder.loads[0].grid.pitch,
        pressure_Pa=np.stack([found.pressure for found in ladder.loads]),
        displacement_m=_displacements(scenario, ladder, reached),
        reading_time_s=reading_time,
        reading_change=change,
        reading_force_N=np.interp(reading_time, time, series.force),
    )


def _displacements(scenario: Scenario, ladder: Ladder, reached: Floats) -> Floats:
    """Of the surface at the end of the hold at each load, (loads, K, 3) m."""
    pairs = zip(ladder.loads, reached, strict=True)
    return np.stack([_displacement(scenario, found, float(force)) for found, force in pairs])


def _displacement(scenario: Scenario, found: Press, force: float) -> Floats:
    """Displacement (K, 3) m of the elastic solution at a force, from the one `found` if it fits."""
    if abs(force - found.force) > SAME * found.force:
        found = press_with(scenario, scenario.tools[0].indenter, force)
    return found.displacement


def _height(scenario: Scenario, plan: Programme, series: Series, depth: Floats) -> Floats:
    """Of the indenter's lowest point above the undeformed surface, (S,) m."""
    profile, row = scenario.profile, series.press
    since = series.time - plan.start[np.maximum(row, 0)]
    high = np.where(row >= 0, profile.height(since), profile.clearance)
    if scenario.loads.forces:
        return np.asarray(high - np.where(series.force > 0, depth, 0.0))
    depths = np.array(scenario.loads.depths)[plan.load[np.maximum(row, 0)]]
    return np.asarray(high - np.where(row >= 0, depths * profile.load(since), 0.0))
