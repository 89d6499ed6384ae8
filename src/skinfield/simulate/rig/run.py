"""Recording on the rig, from the programme of presses to counts, with the truth beside it."""

import zlib
from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import Floats, InputError, Ints
from skinfield.simulate.electronics.array import TaxelArray, recording
from skinfield.simulate.electronics.delivery import Sampling
from skinfield.simulate.indenters.body import Indenter
from skinfield.simulate.pressing.press import Press, press, press_ladder
from skinfield.simulate.rig.scenario import LoadSeries, Pose, Scenario
from skinfield.skin.reading import Recording


@dataclass(frozen=True, eq=False)
class RigTruth:
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
    load_shear_N : (N, 2) array
        Of each load along the plane, as the indenter sees it.
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
    taxel_plane_m : (L, 2) array
        Where the taxels truly are in the patch's plane.
    layer_thickness_m, layer_young_modulus_Pa, layer_poisson_ratio : float
        True ones.
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
    load_shear_N: Floats
    load_effective_force_N: Floats
    plane_m: Floats
    cell_m: float
    pressure_Pa: Floats
    displacement_m: Floats
    reading_time_s: Floats
    reading_change: Floats
    reading_force_N: Floats
    taxel_plane_m: Floats
    layer_thickness_m: float
    layer_young_modulus_Pa: float
    layer_poisson_ratio: float

    def arrays(self) -> dict[str, NDArray[np.generic]]:
        """All by name, as they are stored."""
        return {item.name: np.asarray(getattr(self, item.name)) for item in fields(self)}


FINE = 4001  # forces at which depths are inverted


@dataclass(frozen=True, eq=False)
class LoadCurve:
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
    left : (loads, poses, L) array, 1/N
        ΔC/C₀ per newton of so little of each load's field that it goes with it.
    loads : tuple of Press
        At the scenario's loads, in their order.
    """

    force: Floats
    depth: Floats
    area: Floats
    change: Floats
    left: Floats
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


def solve_ladder(scenario: Scenario, indenter: Indenter, poses: Sequence[Pose]) -> LoadCurve:
    """Press an indenter of the scenario up to its highest load."""
    loads = _loads(scenario, indenter)
    highest = max(load.force for load in loads)
    steps = np.sqrt(highest) * np.arange(1, scenario.solving.rungs) / scenario.solving.rungs
    distance = np.abs(steps[:, None] - np.sqrt([load.force for load in loads])).min(axis=1)
    rungs = steps[distance > 0.25 * steps[0]] ** 2  # the loads stand for those near to them
    every = sorted([*loads, *_pressed(scenario, indenter, rungs)], key=lambda each: each.force)
    used = every[:1]
    used += [b for a, b in pairwise(every) if b.force > a.force * 1.0001]
    plane = scenario.true_plane
    taxels = np.concatenate([pose.taxels(plane) for pose in poses])
    pads, shape = scenario.patch.pad_diameter, (-1, len(poses), len(plane))
    change = [each.capacitance(taxels, pads) for each in used]
    left = [_little(each).capacitance(taxels, pads) / (LITTLE * each.force) for each in loads]
    return LoadCurve(
        np.array([0.0, *(each.force for each in used)]),
        np.array([0.0, *(each.approach[0] for each in used)]),
        np.array([0.0, *(each.contact_area for each in used)]),
        np.stack([np.zeros(len(taxels)), *change]).reshape(shape),
        np.stack(left).reshape(shape),
        tuple(loads),
    )


LITTLE = 0.02  # of a load: readings go with it


def _little(load: Press) -> Press:
    """A little of the field of a load."""
    parts = (replace(each, traction=LITTLE * each.traction) for each in load.touches)
    return replace(load, touches=tuple(parts))


def _loads(scenario: Scenario, indenter: Indenter) -> list[Press]:
    """Presses at the loads, by force or depth."""
    if scenario.loads.forces:
        return _pressed(scenario, indenter, scenario.loads.forces)
    bodies = [replace(indenter, force=None, depth=depth) for depth in scenario.loads.depths]
    solving, layer = scenario.solving, scenario.true_layer
    return [
        press(layer, [each], solving.extent, solving.cell, scenario.mechanics) for each in bodies
    ]


def _pressed(
    scenario: Scenario, indenter: Indenter, forces: Floats | Sequence[float]
) -> list[Press]:
    solving, layer, loads = scenario.solving, scenario.true_layer, scenario.loads
    where = solving.extent, solving.cell, scenario.mechanics
    if not any(loads.shear_part):
        return press_ladder(layer, indenter, forces, *where)
    friction = loads.friction or None
    x, y = loads.shear_part
    pushed = [replace(indenter, force=force, shear=(force * x, force * y)) for force in forces]
    return [press(layer, [each], *where, friction) for each in pushed]


STEP = 2e-3  # s, of the series
FORGOTTEN = 25.0  # retardation times after which a press is over: exp(-25) is 1e-11


@dataclass(frozen=True, eq=False)
class Programme:
    """Presses of a recording, every load at every pose, and when they are.

    Attributes
    ----------
    poses : tuple of Pose
        Distinct ones.
    pose, load : (P,) int arrays
        Of each press.
    start : (P,) array, s
        When each press comes down.
    time : (S,) array, s
        Of the series.
    press : (S,) int array
        Row of the press under way, -1 before the first and after the last.
    """

    poses: tuple[Pose, ...]
    pose: Ints
    load: Ints
    start: Floats
    time: Floats
    press: Ints


def programme(scenario: Scenario) -> Programme:
    """Every load at every pose of a scenario, in order."""
    poses, loads, profile = scenario.poses, len(scenario.loads), scenario.profile
    distinct = tuple(dict.fromkeys(poses))
    presses = len(poses) * loads
    steps = int(np.floor(profile.duration(presses) / STEP + 1e-9))
    time: Floats = STEP * np.arange(steps + 1, dtype=np.float64)
    row = np.floor((time - profile.rest) / profile.period + 1e-9).astype(np.int64)
    return Programme(
        distinct,
        np.repeat([distinct.index(pose) for pose in poses], loads).astype(np.int64),
        np.tile(np.arange(loads), len(poses)).astype(np.int64),
        profile.starts(presses),
        time,
        np.where((row < 0) | (row >= presses), -1, row),
    )


def _loaded(
    scenario: Scenario, plan: Programme, ladder: LoadCurve, pose: int
) -> tuple[slice, Floats, Floats]:
    """Samples of the series in which loads at one pose matter, with forces (W,) N.

    Those into the skin, and the effective ones of the elastic solution: what is left of a press
    fades under the next one at the same place.
    """
    time, profile, loads, elastomer = (
        plan.time,
        scenario.profile,
        scenario.loads,
        scenario.elastomer,
    )
    fades = FORGOTTEN * elastomer.retardation_time
    mine = plan.pose == pose
    starts, heights = plan.start[mine], np.array(loads.forces or loads.depths)[plan.load[mine]]
    first, last = np.searchsorted(time, [starts[0], starts[-1] + profile.period + fades])
    window = slice(int(first), int(last))
    own = time[window]
    force = np.zeros(len(own))
    for start, height in zip(starts, heights, strict=True):
        part = slice(*np.searchsorted(own, [start, start + profile.period]))
        force[part] += height * profile.load(own[part] - start)
    if loads.depths:  # the skin is left behind where it would have to pull
        up = force <= 0.0
        force = np.maximum(elastomer.relaxing_force(own, ladder.force_at(force)), 0.0)
        force[up] = 0.0
    return window, force, np.maximum(elastomer.effective_force(own, force), 0.0)


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
    truth : RigTruth
    """

    scenario: Scenario
    recording: Recording
    load_cell: LoadSeries
    skin: TaxelArray
    truth: RigTruth


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
    plan = programme(scenario)
    ladder = solve_ladder(scenario, tool.indenter, plan.poses)
    chance = scenario.random(2, zlib.crc32(tool.name.encode()), scenario.first_repeat)
    clock, noise, cell = chance.spawn(3)
    end, warm = float(plan.time[-1]), scenario.temperature
    sampling = skin.sample_times(end, clock)
    force, effective, change = _felt(scenario, plan, ladder, sampling)
    part = np.clip(sampling.time / end, 0.0, 1.0)
    sent = recording(
        skin,
        sampling,
        change,
        warm.start + (warm.end - warm.start) * part,
        noise,
        source=f"virtual rig {scenario.name}, {tool.name}",
    )
    load_cell = scenario.load_cell.measure(plan.time, force, cell)
    rows = sampling.logged[0]
    truth = _truth(scenario, plan, ladder, force, effective, sampling.time[rows], change[rows])
    return RigRun(scenario, sent, load_cell, skin, truth)


def _felt(
    scenario: Scenario, plan: Programme, ladder: LoadCurve, sampling: Sampling
) -> tuple[Floats, Floats, Floats]:
    """Force and effective force (S,) N of the series, and ΔC/C₀ (T, L) of taxels as converted."""
    time = plan.time
    force, effective = np.zeros(len(time)), np.zeros(len(time))
    skews, column = np.unique(sampling.skew, return_inverse=True)
    change = np.zeros((len(sampling), len(sampling.skew)))
    last_press = np.maximum.accumulate(plan.press)
    last_pose = np.where(last_press < 0, -1, plan.pose[last_press])
    for pose in range(len(plan.poses)):
        own, pushed, felt = _loaded(scenario, plan, ladder, pose)
        force[own] += pushed
        effective[own] = np.where(last_pose[own] == pose, felt, effective[own])
        rows = slice(*np.searchsorted(sampling.time, [time[own][0] - skews[-1], time[own][-1]]))
        instants = sampling.time[rows, None] + skews
        at, held = (
            np.interp(instants, time[own], each, left=0.0, right=0.0) for each in (felt, pushed)
        )
        pressed = ladder.change_at(pose, at, column.astype(np.int64))
        # What is left of a load, once it goes, fades with its field: exactly, when it is gone.
        share = np.divide(held, at, out=np.ones_like(at), where=at > 0.0).clip(0.0, 1.0)
        touches = plan.start + scenario.profile.approach
        begun = np.searchsorted(touches, instants[:, 0], side="right") - 1
        mine = np.flatnonzero(plan.pose == pose)
        last = mine[np.maximum(np.searchsorted(mine, begun, side="right") - 1, 0)]
        left = at[:, column] * ladder.left[plan.load[last], pose]
        change[rows] += share[:, column] * pressed + (1.0 - share[:, column]) * left
    return force, effective, change


def _truth(
    scenario: Scenario,
    plan: Programme,
    ladder: LoadCurve,
    force: Floats,
    effective: Floats,
    reading_time: Floats,
    change: Floats,
) -> RigTruth:
    profile, time, start, loads = scenario.profile, plan.time, plan.start, ladder.loads
    depth = ladder.depth_at(effective)
    area = np.where(force > 0, ladder.area_at(effective), 0.0)
    hold_end = start + profile.approach + profile.ramp + profile.hold
    layer = scenario.true_layer
    at_end = np.minimum(np.rint(hold_end / STEP).astype(np.int64), len(time) - 1)
    reached = np.array([effective[at_end][plan.load == load].max() for load in range(len(loads))])
    pose = [plan.poses[row] for row in plan.pose]
    return RigTruth(
        time_s=time,
        force_N=force,
        effective_force_N=effective,
        depth_m=depth,
        height_m=_height(scenario, plan, force, depth),
        contact_area_m2=area,
        press=plan.press,
        press_x_m=np.array([p.x for p in pose]),
        press_y_m=np.array([p.y for p in pose]),
        press_angle_rad=np.array([p.angle for p in pose]),
        press_load=plan.load,
        press_start_s=start,
        press_touch_s=start + profile.approach,
        press_hold_s=start + profile.approach + profile.ramp,
        press_release_s=hold_end,
        press_end_s=hold_end + profile.release,
        press_force_N=force[at_end],
        press_effective_force_N=effective[at_end],
        press_depth_m=depth[at_end],
        press_area_m2=area[at_end],
        load_force_N=np.array([load.force for load in loads]),
        load_shear_N=np.array([load.shears[0] for load in loads]),
        load_effective_force_N=reached,
        plane_m=loads[0].grid.plane,
        cell_m=loads[0].grid.pitch,
        pressure_Pa=np.stack([load.pressure for load in loads]),
        displacement_m=np.stack(
            [_at(scenario, *each) for each in zip(loads, reached, strict=True)]
        ),
        reading_time_s=reading_time,
        reading_change=change,
        reading_force_N=np.interp(reading_time, time, force),
        taxel_plane_m=scenario.true_plane,
        layer_thickness_m=layer.thickness,
        layer_young_modulus_Pa=layer.young_modulus,
        layer_poisson_ratio=layer.poisson_ratio,
    )


def _at(scenario: Scenario, load: Press, force: float) -> Floats:
    """Displacement (K, 3) m of the elastic solution at a force, from that of a load if it fits."""
    if abs(force - load.force) > SAME * load.force:
        load = _pressed(scenario, scenario.tools[0].indenter, [float(force)])[0]
    return load.displacement


def _height(scenario: Scenario, plan: Programme, force: Floats, depth: Floats) -> Floats:
    """Of the indenter's lowest point above the undeformed surface, (S,) m."""
    profile, row = scenario.profile, plan.press
    since = plan.time - plan.start[np.maximum(row, 0)]
    high = np.where(row >= 0, profile.height(since), profile.clearance)
    if scenario.loads.forces:
        return np.asarray(high - np.where(force > 0, depth, 0.0))
    depths = np.array(scenario.loads.depths)[plan.load[np.maximum(row, 0)]]
    return np.asarray(high - np.where(row >= 0, depths * profile.load(since), 0.0))
