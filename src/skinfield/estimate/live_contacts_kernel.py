"""Contacts of a live loop, compiled: regions, what they amount to, and which are those of before.

Nothing is allocated. Regions come from `regions_kernel`; see `skinfield.estimate.live_contacts`
for the rows.
"""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from skinfield.compiled import inner, njit
from skinfield.errors import Floats, Ints
from skinfield.estimate.regions_kernel import (
    REGIONS,
    STARTS,
    TIE,
    Work,
    comes_first,
    flood,
    highest_of,
    keep_high,
)

CELLS = 96  # of a region up to which its deviations are exact; of larger ones, evenly thinned
NS = 1e-9
COLUMNS, PITCH, X, Y, SIGMAS, HEIGHT, PROMINENCE, EDGE = range(8)  # of a level's numbers
FORCE_PART, PLACE, SIGN, THRESHOLD = range(8, 12)
REACH, SPEED, HOLD, SMOOTH = range(4)  # of `habits`: m, m/s, s, s


class Level(NamedTuple):
    """What is known of one grid: see `skinfield.estimate.live_contacts.level_of`."""

    std: Floats
    positions: Floats
    normals: Floats
    factor: NDArray[np.float32]
    prior: Floats
    signatures: NDArray[np.float32]
    numbers: Floats


class Room(NamedTuple):
    """Room to work in."""

    wet: Ints
    values: Floats
    tables: Ints
    strongest: Ints
    forces: Floats
    moved: Floats
    picked: Floats
    residual: Floats
    signature: Floats


@njit
def tell(
    pressure: Floats,
    level: Level,
    room: Room,
    habits: Floats,
    memory: Any,
    ids: Ints,
    patch: int,
    now: int,
    out: Any,
) -> int:
    """Write the strongest contacts into `out`, by falling force; how many there are in all."""
    work: Work = (room.wet, room.values, room.tables)
    count = regions(pressure, level, work)
    many = strongest(pressure, count, level, room, len(out))
    if many > 1 and level.numbers[THRESHOLD] > 0.0:
        kept = standing_out(pressure, many, level, room)
        many, count = kept, count - (many - kept)
    for place in range(many):
        describe(pressure, room.strongest[place], level, room, out[place])
        out[place].patch = patch
    associate(many, level, habits, memory, ids, now, room, out)
    return count


@inner
def standing_out(pressure: Floats, many: int, level: Level, room: Room) -> int:
    """Drop listed regions that noise explains as well, given the others; how many are kept.

    A field that is nowhere negative fits what it can of the noise. What a region reads, s in units
    of the noise, is looked for in the residual r without that region: s (r + s) / |s| is the
    matched filter's answer, and must exceed the threshold by which an idle patch is told. The
    strongest region is that for which the patch is not idle: it stays.
    """
    residual, signature, listed = room.residual, room.signature, room.strongest
    cells, starts = room.tables[REGIONS], room.tables[STARTS]
    for cell in range(len(pressure)):
        if pressure[cell] > 0.0:
            add_to(residual, level.signatures[cell], -pressure[cell])
    kept = 1
    for place in range(1, many):
        region = listed[place]
        signature[:] = 0.0
        for cell in cells[starts[region] : starts[region + 1]]:
            add_to(signature, level.signatures[cell], pressure[cell])
        across, square = 0.0, 0.0
        for taxel in range(len(signature)):
            across += signature[taxel] * residual[taxel]
            square += signature[taxel] * signature[taxel]
        if across + square >= level.numbers[THRESHOLD] * np.sqrt(square):
            listed[kept] = region
            kept += 1
    return kept


@inner
def add_to(total: Floats, row: NDArray[np.float32], weight: float) -> None:
    """Add a row, weighted."""
    for taxel in range(len(total)):
        total[taxel] += weight * row[taxel]


@inner
def regions(pressure: Floats, level: Level, work: Work) -> int:
    """Find regions as a `ContactFinder` does; how many there are."""
    known, std = level.numbers, level.std
    least = known[HEIGHT] * highest_of(pressure)
    if not stands_out(pressure, std, known[SIGMAS], least):
        return 0
    edge, columns, sigmas = known[EDGE], int(known[COLUMNS]), known[SIGMAS]
    count = flood(pressure, std, columns, sigmas, known[PROMINENCE], edge * least, edge, work)
    return int(keep_high(pressure, std, sigmas, least, count, work))


@inner
def stands_out(pressure: Floats, std: Floats, sigmas: float, least: float) -> bool:
    """Whether any cell is above its noise and above `least`.

    The noise is only read where the pressure is that high: elsewhere it need not be at hand.
    """
    for cell in range(len(pressure)):
        if pressure[cell] > least and pressure[cell] > sigmas * std[cell]:
            return True
    return False


@inner
def strongest(pressure: Floats, count: int, level: Level, room: Room, most: int) -> int:
    """List the regions of the largest sums, falling; how many are listed."""
    starts, cells = room.tables[STARTS], room.tables[REGIONS]
    listed, forces = room.strongest, room.forces
    many = 0
    for region in range(count):
        total = 0.0
        for cell in cells[starts[region] : starts[region + 1]]:
            total += pressure[cell]
        place, first = many, cells[starts[region]]
        while place > 0:
            other = listed[place - 1]
            if not comes_first(total, first, forces[place - 1], cells[starts[other]]):
                break
            if place < most:
                forces[place], listed[place] = forces[place - 1], other
            place -= 1
        if place < most:
            forces[place], listed[place] = total, region
            many = min(many + 1, most)
    return many


@inner
def describe(pressure: Floats, region: int, level: Level, room: Room, row: Any) -> None:
    """What one region amounts to; its place in the plane goes to `position` for now."""
    known, columns = level.numbers, int(level.numbers[COLUMNS])
    pitch = known[PITCH]
    first, last = room.tables[STARTS][region], room.tables[STARTS][region + 1]
    cells = room.tables[REGIONS][first:last]
    total, x, y, peak = 0.0, 0.0, 0.0, 0.0
    for cell in cells:
        value = pressure[cell]
        total += value
        x += value * (cell % columns)
        y += value * (cell // columns)
        peak = max(peak, value)
    x, y = x / total, y / total
    xx, yy, xy = 0.0, 0.0, 0.0
    for cell in cells:
        dx, dy = cell % columns - x, cell // columns - y
        xx += pressure[cell] * dx * dx
        yy += pressure[cell] * dy * dy
        xy += pressure[cell] * dx * dy
    share = pitch * pitch / total
    own = pitch * pitch / 12.0  # of a cell
    row.moments[0], row.moments[1], row.moments[2] = share * xx + own, share * yy + own, share * xy
    row.cells, row.area, row.peak_pressure = len(cells), len(cells) * pitch * pitch, peak
    deviations(cells, x, y, total, level, room, row)
    stand(pressure, cells, x, y, level, row)


@inner
def stand(pressure: Floats, cells: Ints, x: float, y: float, level: Level, row: Any) -> None:
    """Set place and normal on the skin, between four nodes, and the force along that normal."""
    columns, pitch = int(level.numbers[COLUMNS]), level.numbers[PITCH]
    rows = len(level.positions) // columns
    left, low = min(int(x), max(columns - 2, 0)), min(int(y), max(rows - 2, 0))
    right, high = min(left + 1, columns - 1), min(low + 1, rows - 1)
    u, v, square = x - left, y - low, 0.0
    for axis in range(3):
        place, normal = 0.0, 0.0
        for corner in range(4):
            node = (high if corner > 1 else low) * columns + (right if corner % 2 else left)
            weight = (v if corner > 1 else 1.0 - v) * (u if corner % 2 else 1.0 - u)
            place += weight * level.positions[node, axis]
            normal += weight * level.normals[node, axis]
        row.position[axis], row.normal[axis] = place, normal
        square += normal * normal
    size, force = np.sqrt(square), 0.0
    for axis in range(3):
        row.normal[axis] /= size
        along = 0.0
        for cell in cells:
            along += pressure[cell] * level.normals[cell, axis]
        force += along * row.normal[axis]
    row.normal_force = force * pitch * pitch
    row.x, row.y = level.numbers[X] + x * pitch, level.numbers[Y] + y * pitch


@inner
def deviations(
    cells: Ints, x: float, y: float, total: float, level: Level, room: Room, row: Any
) -> None:
    """Set one standard deviation of force and place, as the covariance of a `Contact` has them."""
    known, columns = level.numbers, int(level.numbers[COLUMNS])
    if known[SIGN] == 0.0:
        row.force_std = row.place_std = np.nan
        return
    stride = (len(cells) - 1) // CELLS + 1
    picked, moved = room.picked, room.moved
    used = 0
    for index in range(0, len(cells), stride):
        picked[0, used] = cells[index] % columns - x
        picked[1, used] = cells[index] // columns - y
        used += 1
    moved[:] = 0.0
    for index in range(used):
        line = level.factor[cells[index * stride]]
        dx, dy = picked[0, index], picked[1, index]
        for taxel in range(len(line)):
            value = line[taxel]
            moved[0, taxel] += value
            moved[1, taxel] += dx * value
            moved[2, taxel] += dy * value
    ones, alongs, acrosses = 0.0, 0.0, 0.0
    for taxel in range(moved.shape[1]):
        ones += moved[0, taxel] * moved[0, taxel]
        alongs += moved[1, taxel] * moved[1, taxel]
        acrosses += moved[2, taxel] * moved[2, taxel]
    if known[SIGN] < 0.0:
        before = of_prior(picked, used, level.prior)
        ones, alongs, acrosses = before[0] - ones, before[1] - alongs, before[2] - acrosses
    share, pitch = len(cells) / used, known[PITCH]
    newtons = share * share * pitch**4
    metres = share * share * pitch * pitch / (total * total)
    force = total * pitch * pitch * known[FORCE_PART]
    row.force_std = np.sqrt(max(ones, 0.0) * newtons + force * force)
    both = max(0.5 * (alongs + acrosses), 0.0)
    row.place_std = np.sqrt(both * metres + known[PLACE] * known[PLACE])


@inner
def of_prior(picked: Floats, used: int, prior: Floats) -> tuple[float, float, float]:
    """Prior variances of the sums of some cells, with weights 1, x and y."""
    own, ones, alongs, acrosses = prior[0, 0], 0.0, 0.0, 0.0
    for index in range(used):
        x, y = picked[0, index], picked[1, index]
        one, along, across = 0.5 * own, 0.5 * own * x, 0.5 * own * y
        for other in range(index):
            dx, dy = picked[0, other], picked[1, other]
            value = prior[int(abs(y - dy) + 0.5), int(abs(x - dx) + 0.5)]
            one += value
            along += value * dx
            across += value * dy
        ones += 2.0 * one
        alongs += 2.0 * along * x
        acrosses += 2.0 * across * y
    return ones, alongs, acrosses


@inner
def associate(
    many: int, level: Level, habits: Floats, memory: Any, ids: Ints, now: int, room: Room, out: Any
) -> None:
    """Give each row the number of the nearest contact of before, or a new one.

    The nearest pair first; of equally near ones, that of the first row, then of the oldest number.
    """
    for row in range(many):
        out[row].track = 0
    for place in range(len(memory)):
        memory[place].taken = 0
        if abs(NS * (now - memory[place].last_ns)) > habits[HOLD]:
            memory[place].track = 0
    for _ in range(many):
        best, row, place = np.inf, -1, -1
        for r in range(many):
            if out[r].track == 0:
                for m in range(len(memory)):
                    if memory[m].track != 0 and memory[m].taken == 0:
                        dx, dy = out[r].x - memory[m].x, out[r].y - memory[m].y
                        apart = np.sqrt(dx * dx + dy * dy)
                        since = max(NS * (now - memory[m].last_ns), 0.0)
                        same = r == row and apart <= (1.0 + TIE) * best
                        older = same and memory[m].track < memory[place].track
                        reach = habits[REACH] + habits[SPEED] * since
                        if apart <= reach and (apart < (1.0 - TIE) * best or older):
                            best, row, place = apart, r, m
        if row < 0:
            break
        out[row].track, memory[place].taken = memory[place].track, 1
        follow(memory[place], habits, now, out[row])
    for row in range(many):
        if out[row].track == 0:
            begin(memory, ids, now, out[row])


@inner
def follow(known: Any, habits: Floats, now: int, row: Any) -> None:
    """Move a contact of before to where it is now, and tell its age and speed."""
    passed = max(NS * (now - known.last_ns), 0.0)
    if passed > 0.0:
        part = 1.0 / (passed + habits[SMOOTH])
        known.vx += part * (row.x - known.x - known.vx * passed)
        known.vy += part * (row.y - known.y - known.vy * passed)
    known.x, known.y, known.last_ns = row.x, row.y, now
    row.age = NS * (now - known.first_ns)
    row.speed = np.sqrt(known.vx * known.vx + known.vy * known.vy)


@inner
def begin(memory: Any, ids: Ints, now: int, row: Any) -> None:
    """Remember a new contact, in place of none, else of the one not seen for longest."""
    place = 0
    for m in range(len(memory)):
        if memory[m].track == 0:
            place = m
            break
        if memory[m].taken == 0 and (
            memory[place].taken == 1 or memory[m].last_ns < memory[place].last_ns
        ):
            place = m
    ids[0] += 1
    known = memory[place]
    known.track, known.taken, known.x, known.y = ids[0], 1, row.x, row.y
    known.first_ns = known.last_ns = now
    known.vx = known.vy = 0.0
    row.track, row.age, row.speed = ids[0], 0.0, 0.0
