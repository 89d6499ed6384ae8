"""Cases of skins with habits: soft fingers, counts of a board, and the documented way from them."""

import math
from collections.abc import Iterator
from dataclasses import dataclass, field, replace

import numpy as np

from skinfield.elastic import Capacitance, Layer
from skinfield.errors import Floats, InputError, Ints
from skinfield.lab.case_sets import DEEPEST, LOADINGS, TRIES
from skinfield.lab.cases import NOTHING, Case, truth_of_press
from skinfield.reconstruct.diagnostics import Conditioning, condition
from skinfield.simulate import Finger, Press, press
from skinfield.simulate.electronics import CySkinBoard, Electronics, cyskin_electronics, recording
from skinfield.simulate.electronics.noise import ROOM
from skinfield.simulate.habits import REAL, Habits, habits_by_name
from skinfield.simulate.rig import Pose
from skinfield.skin import Patch
from skinfield.skin.reading import Recording

FOAM = Layer(2e-3, 50e3, 0.3)  # on it a finger of a few newtons reads as much as on CySkin
MOST_FINGERS = 5
LOADS = (2.0, 6.0)  # N: of each finger, log-uniform, and lighter where the layer bears less
LIGHTER = 0.7
APART = 20e-3  # m: least distance of lobes of different fingers
SIZES = 0.15  # of the logarithm of a finger's width and length
CELL = 1e-3  # m
NEAR = 12e-3  # m: beyond a touch, where readings are below 1e-3 of the highest
REST, RAMP, HOLD = 4.0, 0.3, 2.0  # s
OVER = 0.3  # of the force: by which a finger presses harder before it holds still, at most
STEP = 2e-3  # s


def _cyskin() -> Electronics:
    board = CySkinBoard()
    return replace(cyskin_electronics(), board=replace(board, gain=board.convention.usual_gain))


@dataclass(frozen=True, kw_only=True)
class HabitCases:
    """Cases of 0 to 5 soft fingers in turn, each on a skin of its own, as they are read.

    A skin is made within the tolerances of its habits, rests, is pressed and held; its counts are
    conditioned as a recording is that nobody knows anything else of. A case has the readings of the
    hold, and states the patch and the layer as a maker does, and the noise as it was measured.

    Parameters
    ----------
    patch : Patch
        As stated.
    habits : Habits
    layer : Layer
        As stated.
    electronics : Electronics
        Of the board, without the habits.
    """

    patch: Patch
    habits: Habits = field(default_factory=lambda: habits_by_name(REAL))
    layer: Layer = FOAM
    electronics: Electronics = field(default_factory=_cyskin)

    def cases(self, count: int = 12, seed: int = 0, draws: int = 4) -> Iterator[Case]:
        """Make cases one after another; the same arguments give the same cases.

        Parameters
        ----------
        count, seed : int
        draws : int
            Readings of each, evenly over the hold; 1 or more.

        Raises
        ------
        InputError
            If the patch has no room for the fingers, or they sink too deep into the layer.
        """
        if draws < 1:
            raise InputError(f"draws is {draws}, expected 1 or more: readings hold noise always")
        for index in range(count):
            yield self._case(index, seed, draws)

    def _case(self, index: int, seed: int, draws: int) -> Case:
        made, pressing, sending = np.random.default_rng([seed, index]).spawn(3)
        layer = self.habits.tolerances.layer(self.layer, made)
        plane = self.habits.tolerances.plane(self.patch, made)
        fingers = index % (MOST_FINGERS + 1)
        solved = self._press(layer, fingers, pressing) if fingers else None
        change = np.zeros(len(self.patch))
        if solved is not None:
            change = self._change(solved, plane)
        counts, held = self._recorded(change, float(pressing.uniform(0.0, OVER)), sending, draws)
        values, found = condition(counts, self.patch, self.layer, Capacitance(), Conditioning())
        return Case(
            name=f"{index:04d}_{fingers}_fingers",
            patch=self.patch,
            layer=self.layer,
            quantity="capacitance",
            readings=values[held],
            noise_std=found.noise_std,
            noisy=True,
            truth=NOTHING if solved is None else truth_of_press(solved, Pose(0.0, 0.0)),
        )

    def _change(self, solved: Press, plane: Floats) -> Floats:
        """ΔC/C₀ (L,) of taxels at (L, 2) m: what each finger makes, added up.

        They are so far apart that the gap below one hardly changes with another.
        """
        change = np.zeros(len(plane))
        for finger in solved.indenters:
            away = plane - finger.position
            reach = finger.reach + NEAR  # type: ignore[attr-defined]
            near = np.linalg.norm(away, axis=1) < reach
            alone = press(solved.layer, [replace(finger, position=(0.0, 0.0))], 2.0 * reach, CELL)
            change[near] += alone.capacitance(away[near], self.patch.pad_diameter)
        return change

    def _press(self, layer: Layer, count: int, rng: np.random.Generator) -> Press:
        """Fingers with random forces, lighter where the layer does not bear them."""
        fingers = self._fingers(count, rng)
        widest = max(
            max(map(abs, each.position)) + replace(each, force=LOADS[1]).reach for each in fingers
        )
        extent = 2.0 * (widest + NEAR)
        forces = np.exp(rng.uniform(math.log(LOADS[0]), math.log(LOADS[1]), count))
        for _ in range(LOADINGS):
            loaded = [
                replace(each, force=float(f)) for each, f in zip(fingers, forces, strict=True)
            ]
            try:
                solved = press(layer, loaded, extent, CELL)
            except InputError as error:
                if "sinks" not in str(error):
                    raise
                forces *= LIGHTER
                continue
            deep = solved.approach > DEEPEST * layer.thickness
            if not deep.any():
                return solved
            forces[deep] *= LIGHTER
        raise InputError(
            f"layer is {layer}, expected one that bears a finger: it sinks deeper than {DEEPEST:g} "
            "of it"
        )

    def _fingers(self, count: int, rng: np.random.Generator) -> list[Finger]:
        """Fingers of several kinds and sizes over taxels, apart from each other."""
        placed: list[Finger] = []
        lobes = np.empty((0, 2))
        for _ in range(TRIES * count):
            kind = self.habits.fingers[int(rng.integers(len(self.habits.fingers)))]
            x, y = self.patch.plane[int(rng.integers(len(self.patch)))]
            x, y = (float(v + rng.uniform(-0.5, 0.5) * self.patch.pitch) for v in (x, y))
            size = float(np.exp(SIZES * rng.standard_normal()))
            one = replace(
                kind, width=kind.width * size, length=(kind.length or kind.width) * size,
                position=(x, y), rotation=float(rng.uniform(0.0, 2.0 * np.pi)),
            )  # fmt: skip
            own = one.middles
            to_taxels = np.linalg.norm(own[:, None] - self.patch.plane, axis=2).min(axis=1)
            to_others = np.linalg.norm(own[:, None] - lobes, axis=2).min(initial=np.inf)
            if to_taxels.max() <= self.patch.pitch and to_others >= APART:
                placed.append(one)
                lobes = np.concatenate([lobes, own])
            if len(placed) == count:
                return placed
        low, high = self.patch.plane.min(axis=0), self.patch.plane.max(axis=0)
        wide, tall = 1e3 * (high - low)
        raise InputError(
            f"patch {self.patch.name!r} is {wide:.0f} x {tall:.0f} mm, expected room for {count} "
            f"fingers that are {APART * 1e3:g} mm apart: take a larger one"
        )

    def _recorded(
        self, change: Floats, over: float, rng: np.random.Generator, draws: int
    ) -> tuple[Recording, Ints]:
        """Recording of a skin that rests and is then pressed, and which readings are of the hold.

        Its force rises by `over` more than it holds; what taxels read goes with the load.
        """
        making, clock, noise = rng.spawn(3)
        skin = self.habits.electronics(self.electronics).manufacture(self.patch, making)
        end = REST + 2.0 * RAMP + HOLD
        time = STEP * np.arange(round(end / STEP) + 1)
        knots = [REST, REST + RAMP, REST + 2.0 * RAMP]
        load = np.interp(time, knots, [0.0, 1.0 + over, 1.0])
        if self.habits.elastomer is not None:
            load = self.habits.elastomer.effective_force(time, load)
        sampling = skin.sample_times(end, clock)
        felt = change * np.interp(sampling.instants, time, load)
        warm = ROOM + self.habits.warming * sampling.time
        sent = recording(skin, sampling, felt, warm, noise, source="simulated fingers")
        rows = np.flatnonzero(sampling.time[sampling.logged[0]] > knots[-1])
        if len(rows) < draws:
            raise InputError(
                f"draws is {draws}, expected at most {len(rows)}: the readings of {HOLD:g} s"
            )
        chosen = rows[np.linspace(0, len(rows) - 1, draws + 2)[1:-1].astype(np.int64)]
        return sent, chosen
