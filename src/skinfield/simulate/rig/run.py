"""Recording on the rig, from the programme of presses to counts, with the truth beside it."""

import zlib
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, fields, replace
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from skinfield.elastic import Viscoelastic
from skinfield.errors import Floats, InputError, Ints
from skinfield.simulate.electronics.array import TaxelArray
from skinfield.simulate.electronics.delivery import Sampling
from skinfield.simulate.electronics.recording import recording
from skinfield.simulate.indenters.body import Indenter
from skinfield.simulate.pressing.press import Press, press, press_ladder
from skinfield.simulate.rig.scenario import Loads, LoadSeries, Pose, Profile, Scenario
from skinfield.skin.reading import Recording


@dataclass(frozen=True, eq=False)
class Truth:
    """Of one recording; its fields are the keys of ``truth.npz``, in SI units.

    Attributes
    ----------
    time_s : (S,) array
        Of the series, every 2 ms, since the start; stamp 0 is time 0.
    force_N : (S,) array
        Into the skin.
    effective_force_N : (S,) array
        Force at which the elastic solution has the displacements of that moment, of the pose that
        is pressed or was pressed last.
    depth_m : (S,) array
        Of the deepest point of the surface below the indenter.
    height_m : (S,) array
        Of the indenter's lowest point above the undeformed surface; negative while it presses.
    contact_area_m2 : (S,) array
        0 where there is no force.
    press : (S,) int array
        Row of the press under way; -1 before the first and after the last.
    press_x_m, press_y_m, press_angle_rad : (P,) arrays
        Pose of the indenter in the patch's plane.
    press_load : (P,) int array
        Row of the load.
    press_start_s, press_touch_s, press_hold_s, press_release_s, press_end_s : (P,) arrays
        When it comes down, touches, has its full load, lets go and is off again.
    press_force_N, press_effective_force_N, press_depth_m, press_area_m2 : (P,) arrays
        At the end of the hold.
    load_force_N : (N,) array
        Of the elastic solution of each load: the force given, or that of the depth given.
    load_effective_force_N : (N,) array
        Highest at any end of hold with that load.
    plane_m : (K, 2) array
        Cells of the fields as the indenter sees them: place = R(angle) plane + (x, y).
    cell_m : float
        Side of a cell.
    pressure_Pa : (N, K) array
        Of each load; sums to its force.
    displacement_m : (N, K, 3) array
        Of the surface, negative z is into the skin, at the effective force of each load.
    reading_time_s : (R,) array
        When the first taxels of each reading were converted.
    reading_change : (R, L) array
        True ΔC/C₀ of the taxels then.
    reading_force_N : (R,) array
        True force at `reading_time_s`.
    """

    time_s: Floats
    force_N: Floats
    effective_force_N: Floats
    depth_m: Floats
    height_m: Floats
    contact_area_m2: Floats
    press: Ints
    press_x_m: Floats
    press_y_m: Floats
    press_angle_rad: Floats
    press_load: Ints
    press_start_s: Floats
    press_touch_s: Floats
    press_hold_s: Floats
    press_release_s: Floats
    press_end_s: Floats
    press_force_N: Floats
    press_effective_force_N: Floats
    press_depth_m: Floats
    press_area_m2: Floats
    load_force_N: Floats
    load_effective_force_N: Floats
    plane_m: Floats
    cell_m: float
    pressure_Pa: Floats
    displacement_m: Floats
    reading_time_s: Floats
    reading_change: Floats
    reading_force_N: Floats

    def arrays(self) -> dict[str, NDArray[np.generic]]:
        """All by name, as they are stored."""
        return {item.name: np.asarray(getattr(self, item.name)) for item in fields(self)}


FINE = 4001  # forces at which depths are inverted


@dataclass(frozen=True, eq=False)
class Ladder:
    """Readings, depth and area over the force, from none to the highest.

    Between the rungs a monotone cubic in √force (PCHIP): there readings are nearly straight lines.

    Attributes
    ----------
    force : (N,) array, N
        From 0 up.
    depth : (N,) array, m
    area : (N,) array, m²
    change : (N, poses, L) array
        ΔC/C₀ of the taxels.
    loads : tuple of Press
        At the scenario's loads, in their order.
    """

    force: Floats
    depth: Floats
    area: Floats
    change: Floats
    loads: tuple[Press, ...]

    def depth_at(self, force: Floats) -> Floats:
        """Of the lowest point, m."""
        return self._between(self.depth, force)

    def area_at(self, force: Floats) -> Floats:
        """Of contact, m²."""
        return self._between(self.area, force)

    def force_at(self, depth: Floats) -> Floats:
        """Elastic force at depths of the lowest point, N: the inverse of `depth_at`."""
        force = self.force[-1] * np.linspace(0.0, 1.0, FINE) ** 2
        root = np.interp(depth, self.depth_at(force), np.sqrt(force))
        return np.asarray(root**2)

    def change_at(self, pose: int, force: Floats, skew: Ints) -> Floats:
        """ΔC/C₀ (T, L) at one pose, under forces (T, S) at the moments of each distinct skew.

        Parameters
        ----------
        pose : int
        force : (T, S) array, N
        skew : (L,) int array
            Column of `force` that counts for each taxel.
        """
        out = np.empty((len(force), self.change.shape[2]))
        for column in range(force.shape[1]):
            taxels = skew == column
            out[:, taxels] = self._between(self.change[:, pose, taxels], force[:, column])
        return out

    def _between(self, values: Floats, force: Floats) -> Floats:
        from scipy.interpolate import PchipInterpolator

        held = np.sqrt(np.clip(force, 0.0, self.force[-1]))
        return np.asarray(PchipInterpolator(np.sqrt(self.force), values)(held))


def solve_ladder(scenario: Scenario, indenter: Indenter, poses: Sequence[Pose]) -> Ladder:
    """Press an indenter of the scenario up to its highest load."""
    loads = _loads(scenario, indenter)
    highest = max(found.force for found in loads)
    rungs = _solve(scenario, indenter, _steps(loads, highest, scenario.solving.rungs))
    every = sorted([*loads, *rungs], key=lambda found: found.force)
    kept = [every[0]]
    kept += [b for a, b in pairwise(every) if b.force > a.force * 1.0001]
    plane = scenario.patch.plane
    seen = np.concatenate([pose.taxels(plane) for pose in poses])
    change = [found.capacitance(seen, scenario.patch.pad_diameter) for found in kept]
    none = np.zeros(1)
    return Ladder(
        np.concatenate([none, [found.force for found in kept]]),
        np.concatenate([none, [float(found.approach[0]) for found in kept]]),
        np.concatenate([none, [found.contact_area for found in kept]]),
        np.stack([np.zeros(len(seen)), *change]).reshape(len(kept) + 1, len(poses), len(plane)),
        tuple(loads),
    )


def press_with(scenario: Scenario, indenter: Indenter, force: float) -> Press:
    """One press at the origin."""
    return _solve(scenario, indenter, np.array([force]))[0]


def _loads(scenario: Scenario, indenter: Indenter) -> list[Press]:
    """Presses at the loads, by force or depth."""
    if scenario.loads.forces:
        return _solve(scenario, indenter, np.array(scenario.loads.forces))
    body: Any = indenter
    solving = scenario.solving
    return [
        press(
            scenario.layer,
            [replace(body, force=None, depth=depth)],
            solving.extent,
            solving.cell,
            scenario.mechanics,
        )
        for depth in scenario.loads.depths
    ]


def _solve(scenario: Scenario, indenter: Indenter, forces: Floats) -> list[Press]:
    solving = scenario.solving
    return press_ladder(
        scenario.layer,
        indenter,
        forces.tolist(),
        solving.extent,
        solving.cell,
        scenario.mechanics,
    )


def _steps(loads: Sequence[Press], highest: float, count: int) -> Floats:
    """Even steps of √force, without those that a load stands near to."""
    steps = np.sqrt(highest) * np.arange(1, count) / count
    taken = np.sqrt([found.force for found in loads])
    distance = np.abs(steps[:, None] - taken).min(axis=1)
    kept: NDArray[np.bool_] = distance > 0.25 * steps[0]
    return np.asarray(steps[kept] ** 2)


STEP = 2e-3  # s, of the series
FORGOTTEN = 25.0  # retardation times after which a press is over: exp(-25) is 1e-11


@dataclass(frozen=True, eq=False)
class Programme:
    """Presses of a recording: every load at every pose.

    Attributes
    ----------
    poses : tuple of Pose
        Distinct ones.
    pose, load : (P,) int arrays
        Of each press.
    profile : Profile
    """

    poses: tuple[Pose, ...]
    pose: Ints
    load: Ints
    profile: Profile

    @property
    def start(self) -> Floats:
        """When each press comes down, (P,) s."""
        return self.profile.starts(len(self.pose))

    @property
    def time(self) -> Floats:
        """Of the series, (S,) s."""
        duration = self.profile.duration(len(self.pose))
        steps = int(np.floor(duration / STEP + 1e-9))
        return np.asarray(STEP * np.arange(steps + 1), dtype=np.float64)

    def under_way(self, time: Floats) -> Ints:
        """Row of the press at times (S,), -1 before the first and after the last."""
        row = np.floor((time - self.profile.rest) / self.profile.period + 1e-9).astype(np.int64)
        return np.where((row < 0) | (row >= len(self.pose)), -1, row)


def programme(poses: Sequence[Pose], loads: Loads, profile: Profile) -> Programme:
    """Every load at every pose, in order."""
    distinct = tuple(dict.fromkeys(poses))
    rows = np.array([distinct.index(pose) for pose in poses])
    count = len(loads)
    return Programme(
        distinct,
        np.repeat(rows, count).astype(np.int64),
        np.tile(np.arange(count), len(poses)).astype(np.int64),
        profile,
    )


@dataclass(frozen=True, eq=False)
class Pressed:
    """Loads at one pose while it matters: samples `window` of the series.

    `force` is that into the skin, `effective` that of the elastic solution, (W,) N.
    """

    pose: int
    window: slice
    force: Floats
    effective: Floats


def pressed(
    plan: Programme, loads: Loads, ladder: Ladder, elastomer: Viscoelastic
) -> Iterator[Pressed]:
    """Loads at each pose; what is left of a press fades under the next one at the same place."""
    time, profile = plan.time, plan.profile
    fades = FORGOTTEN * max((late for _, late in elastomer.retardation), default=0.0)
    amount = np.array(loads.forces or loads.depths)
    for pose in range(len(plan.poses)):
        starts, heights = plan.start[plan.pose == pose], amount[plan.load[plan.pose == pose]]
        first = int(np.searchsorted(time, starts[0]))
        last = int(np.searchsorted(time, starts[-1] + profile.period + fades, side="right"))
        own = time[first:last]
        commanded = np.zeros(len(own))
        for start, height in zip(starts, heights, strict=True):
            part = slice(*np.searchsorted(own, [start, start + profile.period]))
            commanded[part] += height * profile.load(own[part] - start)
        if loads.forces:
            force = commanded
        else:  # the skin is left behind where it would have to pull
            force = np.maximum(elastomer.relaxing_force(own, ladder.force_at(commanded)), 0.0)
            force[commanded <= 0.0] = 0.0
        effective = np.maximum(elastomer.effective_force(own, force), 0.0)
        yield Pressed(pose, slice(first, last), force, effective)


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
