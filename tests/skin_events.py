"""Contact lists of iCub's skinManager, and yarpdatadumper, in plain Python; nothing of skinfield.

After `Compensator::getContacts` of icub-main 2.11.1 (src/modules/skinManager/src/compensator.cpp):
taxels above a threshold that are neighbours make one contact; place and normal are their means,
weighted by what they read; the force is 0.05 of all counts along the mean normal; every contact of
every list has a number of its own. The dumper writes a line twice now and then, in place of the
next one.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from itertools import count
from pathlib import Path

import numpy as np

SPACING, NEIGHBOURS = 6.5e-3, 15e-3  # m
THRESHOLD = 7.0  # counts
START = 1_700_000_000.25  # s
Press = tuple[float, float, float, float]  # angle and place along, m; counts; width, m


@dataclass(frozen=True)
class Arm:
    """A round link with taxels on a hexagonal lattice: numbers in skinDynLib, radius in m."""

    numbers: tuple[int, int, int]
    radius: float = 0.04
    along: float = 0.1

    @property
    def lattice(self) -> np.ndarray:
        """Places (L, 2) m: round the link, and along it."""
        rows = np.arange(0.0, self.along, SPACING * np.sqrt(0.75))
        around = np.arange(-0.45, 0.45, SPACING / (2 * np.pi * self.radius)) * 2 * np.pi
        return np.array([
            (self.radius * angle + SPACING / 2 * (row % 2), y)
            for row, y in enumerate(rows) for angle in around
        ])  # fmt: skip

    def contacts(
        self, presses: Sequence[Press], rng: np.random.Generator, ids: Iterator[int]
    ) -> list[str]:
        """Contacts as a bottle's text."""
        flat = self.lattice
        read = rng.normal(0.0, 1.5, len(flat))
        for x, y, counts, width in presses:
            read += counts * np.exp(-((flat - (x, y)) ** 2).sum(1) / (2 * width**2))
        active = np.flatnonzero(read > THRESHOLD)
        angle = flat[:, 0] / self.radius
        normals = np.column_stack([np.sin(angle), np.zeros_like(angle), np.cos(angle)])
        places = self.radius * normals + np.column_stack([0 * angle, flat[:, 1], 0 * angle])
        found = []
        for group in groups_of(places[active]):
            taxels = active[group]
            weight = read[taxels] / read[taxels].sum()
            normal, pressure = weight @ normals[taxels], read[taxels].mean()
            force = -0.05 * len(taxels) * pressure * normal
            vectors = (
                weight @ places[taxels], force, np.zeros(3), places[taxels].mean(0), normal,
            )  # fmt: skip
            lists = " ".join(f"({' '.join(map(double, each))})" for each in vectors)
            body, link, skin = self.numbers
            numbers = f"({next(ids)} {body} {link} {skin})"
            listed = " ".join(map(str, taxels))
            found.append(f"({numbers} {lists} ({listed}) {double(pressure)})")
        return found


def groups_of(places: np.ndarray) -> list[np.ndarray]:
    """Places whose chains of neighbours meet."""
    near = np.linalg.norm(places[:, None] - places[None], axis=2) < NEIGHBOURS
    label = np.arange(len(places))
    for _ in places:
        label = np.array([label[row].min() for row in near])
    return [np.flatnonzero(label == each) for each in np.unique(label)]


def double(value: float) -> str:
    """As YARP prints it: 15 digits, always with a point or an exponent."""
    text = f"{value:.15g}"
    return text if any(c in text for c in ".en") else text + ".0"


def log_of(
    arms: Sequence[Arm],
    presses: Callable[[int], Sequence[Sequence[Press]]],
    readings: int,
    seed: int = 0,
    repeated: float = 0.0,
) -> str:
    """Log of so many lists: `presses` of a reading are those of each arm.

    `repeated` is the share of lines that stand there twice, in place of the next one.
    """
    rng, ids = np.random.default_rng(seed), count(70_000)
    seconds = START + np.cumsum(rng.uniform(0.010, 0.030, readings))
    lines = []
    for k in range(readings):
        each = (arm.contacts(on, rng, ids) for arm, on in zip(arms, presses(k), strict=True))
        lists = " ".join(text for texts in each for text in texts)
        if lines and rng.uniform() < repeated:
            lines.append(lines[-1])
        else:
            lines.append(f"{500 + k} {seconds[k]:.6f} {lists}\n")
    return "".join(lines)


def dump(folder: Path, text: str) -> Path:
    """The folder that yarpdatadumper makes of it."""
    folder.mkdir(parents=True)
    (folder / "data.log").write_text(text)
    (folder / "info.log").write_text(
        "Type: Bottle;\n[1699999990.500000] /skinManager/skin_events:o [connected]\n"
    )
    return folder
