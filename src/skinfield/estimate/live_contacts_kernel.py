"""Contacts of a field as rows, compiled: what regions amount to.

Nothing is allocated. Regions come from `regions_kernel`; see `skinfield.estimate.row_contacts` for
the rows.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from skinfield.compiled import inner, njit
from skinfield.errors import Floats, Ints
from skinfield.estimate.regions_kernel import REGIONS, SPARE, STARTS, find
from skinfield.estimate.track_memory import FLOORS, NOW, TOP, TrackMemory
from skinfield.estimate.tracking_kernel import FORCE_FLOOR, track

CELLS = 96  # of a region up to which its deviations are exact; of larger ones, evenly thinned
TIE = 1e-9  # as in `skinfield.estimate.ranking`: forces that differ by this part are equal
# Of a level's numbers:
COLUMNS, PITCH, X, Y, FORCE_PART, PLACE, SIGN, THRESHOLD, AREA, HEIGHTS = range(10)
XX, XY, YY, X_FORCE, Y_FORCE, FORCE_FORCE = range(6)  # of a row's covariance


@njit
def find_rows(
    pressure: Floats,
    std: Floats,
    positions: Floats,
    normals: Floats,
    factor: NDArray[np.float32],
    prior: Floats,
    signatures: NDArray[np.float32],
    numbers: Floats,
    wet: Ints,
    values: Floats,
    tables: Ints,
    taxels: Floats,
    residual: Floats,
    patch: int,
    out: Any,
) -> int:
    """Write the strongest contacts of a field into `out`, by falling force; how many there are.

    `std` to `numbers` are a level's, `wet` to `residual` its room: `residual` (L,) holds whitened
    readings. Which regions the rows are of is left in `SPARE` of the tables.
    """
    columns, heights = int(numbers[COLUMNS]), numbers[HEIGHTS:]
    count = find(pressure, std, columns, heights, wet, values, tables)
    starts, cells, listed = tables[STARTS], tables[REGIONS], tables[SPARE]
    many = list_strongest(pressure, count, starts, cells, listed, values[0], len(out))
    if many > 1 and numbers[THRESHOLD] > 0.0:
        listed_before = many
        many = standing_out(
            pressure, many, starts, cells, listed, signatures, residual, taxels[3], numbers
        )
        count -= listed_before - many
    for place in range(many):
        region, row = listed[place], out[place]
        mine = cells[starts[region] : starts[region + 1]]
        total = describe(pressure, mine, numbers, row)
        row["patch"], row["force_std"], row["place_std"] = patch, np.nan, np.nan
        row["shape"], row["maybe"], row["radius"] = 0, 0, np.sqrt(row["area"] / np.pi)
        row["area_std"], covariance = np.nan, row["covariance"]
        for number in range(6):
            covariance[number] = np.nan
        for axis in range(3):
            row["shear"][axis], row["shear_covariance"][axis] = 0.0, np.nan
        if numbers[SIGN] != 0.0:
            deviations(mine, total, factor, prior, numbers, values, taxels, row)
        stand(pressure, mine, positions, normals, numbers, row)
    return count


@njit
def take_rows(
    rows: Any,
    words: NDArray[np.int64],
    many: int,
    shift: Floats,
    positions: Floats,
    normals: Floats,
    numbers: Floats,
    patch: int,
    out: Any,
    out_words: NDArray[np.int64],
) -> int:
    """Write contacts that a solver has found; how many.

    Parameters
    ----------
    rows : (N,) array of CONTACT
        By falling force, `many` of them, on a patch of equal geometry; `words` is their memory.
    shift : (2,) array, m
        From the plane of that patch to this one's.
    positions, normals, numbers
        Of this patch's finest level.
    out : array of CONTACT
        With its memory, `out_words`.
    """
    told = min(many, len(out))
    for word in range(told * (len(out_words) // max(len(out), 1))):
        out_words[word] = words[word]
    for place in range(told):
        out[place].patch = patch
    if shift[0] != 0.0 or shift[1] != 0.0:
        move_rows(out[:told], shift, positions, normals, numbers)
    return many


@njit
def move_rows(
    rows: Any, shift: Floats, positions: Floats, normals: Floats, numbers: Floats
) -> None:
    """Move contacts in the plane by a shift (2,), m, onto another patch; see `take_rows`."""
    for place in range(len(rows)):
        row = rows[place]
        row["x"], row["y"] = row["x"] + shift[0], row["y"] + shift[1]
        u, v = (row["x"] - numbers[X]) / numbers[PITCH], (row["y"] - numbers[Y]) / numbers[PITCH]
        put_on(row, u, v, positions, normals, int(numbers[COLUMNS]))


@inner
def list_strongest(
    pressure: Floats, count: int, starts: Ints, cells: Ints, listed: Ints, forces: Floats, most: int
) -> int:
    """List the regions of the largest sums, falling, then by rising first cell; how many."""
    many = 0
    for region in range(count):
        total, first, place = 0.0, cells[starts[region]], many
        for cell in cells[starts[region] : starts[region + 1]]:
            total += pressure[cell]
        while place > 0:
            other = forces[place - 1]
            tied = abs(total - other) <= TIE * abs(other)
            if (tied and first > cells[starts[listed[place - 1]]]) or (not tied and total < other):
                break
            if place < most:
                forces[place], listed[place] = other, listed[place - 1]
            place -= 1
        if place < most:
            forces[place], listed[place] = total, region
            many = min(many + 1, most)
    return many


@inner
def standing_out(
    pressure: Floats,
    many: int,
    starts: Ints,
    cells: Ints,
    listed: Ints,
    signatures: NDArray[np.float32],
    residual: Floats,
    signature: Floats,
    numbers: Floats,
) -> int:
    """Drop listed regions that noise explains as well, given the others; how many are kept.

    A field that is nowhere negative fits what it can of the noise. What a region reads, s in units
    of the noise, is looked for in the residual r without that region: s (r + s) / |s| is the
    matched filter's answer, and must exceed the threshold by which an idle patch is told. The
    strongest region is that for which the patch is not idle: it stays.
    """
    for cell in range(len(pressure)):
        if pressure[cell] > 0.0:
            for taxel in range(len(residual)):
                residual[taxel] -= pressure[cell] * signatures[cell, taxel]
    kept = 1
    for place in range(1, many):
        region = listed[place]
        signature[:] = 0.0
        for cell in cells[starts[region] : starts[region + 1]]:
            for taxel in range(len(residual)):
                signature[taxel] += pressure[cell] * signatures[cell, taxel]
        across, square = 0.0, 0.0
        for taxel in range(len(residual)):
            across += signature[taxel] * residual[taxel]
            square += signature[taxel] * signature[taxel]
        if across + square >= numbers[THRESHOLD] * np.sqrt(square):
            listed[kept] = region
            kept += 1
    return kept


@inner
def describe(pressure: Floats, cells: Ints, numbers: Floats, row: Any) -> float:
    """What one region amounts to; its place `x`, `y` is counted in cells. Returns its sum, Pa."""
    columns, pitch = int(numbers[COLUMNS]), numbers[PITCH]
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
    moments = row["moments"]
    moments[0], moments[1], moments[2] = share * xx + own, share * yy + own, share * xy
    row["cells"], row["peak_pressure"] = len(cells), peak
    row["area"] = len(cells) * numbers[AREA]
    row["x"], row["y"] = x, y
    return float(total)


@inner
def stand(
    pressure: Floats, cells: Ints, positions: Floats, normals: Floats, numbers: Floats, row: Any
) -> None:
    """Set place and normal on the skin, between four nodes, and the force along that normal."""
    columns, pitch, x, y = int(numbers[COLUMNS]), numbers[PITCH], row["x"], row["y"]
    put_on(row, x, y, positions, normals, columns)
    outward, force = row["normal"], 0.0
    for axis in range(3):
        along = 0.0
        for cell in cells:
            along += pressure[cell] * normals[cell, axis]
        force += along * outward[axis]
    row["normal_force"] = force * numbers[AREA]
    row["x"], row["y"] = numbers[X] + x * pitch, numbers[Y] + y * pitch


@inner
def put_on(row: Any, x: float, y: float, positions: Floats, normals: Floats, columns: int) -> None:
    """Set place and normal on the skin of `x` and `y`, counted in cells: between four nodes."""
    rows = len(positions) // columns
    left = min(max(int(x), 0), max(columns - 2, 0))
    low = min(max(int(y), 0), max(rows - 2, 0))
    right, high = min(left + 1, columns - 1), min(low + 1, rows - 1)
    u, v, square = x - left, y - low, 0.0
    position, outward = row["position"], row["normal"]
    for axis in range(3):
        place, normal = 0.0, 0.0
        for corner in range(4):
            node = (high if corner > 1 else low) * columns + (right if corner % 2 else left)
            weight = (v if corner > 1 else 1.0 - v) * (u if corner % 2 else 1.0 - u)
            place += weight * positions[node, axis]
            normal += weight * normals[node, axis]
        position[axis], outward[axis] = place, normal
        square += normal * normal
    size = np.sqrt(square)
    for axis in range(3):
        outward[axis] /= size


@inner
def lay_along(row: Any, x: float, y: float, positions: Floats, columns: int) -> None:
    """Turn a force along the skin, at `x` and `y` in cells, from the plane into the frame."""
    left = min(max(int(x), 0), max(columns - 2, 0))
    low = min(max(int(y), 0), max(len(positions) // columns - 1, 0))
    first, second = low * columns + left, low * columns + min(left + 1, columns - 1)
    shear, normal = row["shear"], row["normal"]
    by_x, by_y, across, square = shear[0], shear[1], 0.0, 0.0
    for axis in range(3):
        across += (positions[second, axis] - positions[first, axis]) * normal[axis]
    for axis in range(3):
        shear[axis] = positions[second, axis] - positions[first, axis] - across * normal[axis]
        square += shear[axis] * shear[axis]
    size = np.sqrt(square)
    if not size > 0.0:
        shear[0] = shear[1] = shear[2] = 0.0
        return
    a, b, c = shear[0] / size, shear[1] / size, shear[2] / size
    shear[0] = by_x * a + by_y * (normal[1] * c - normal[2] * b)
    shear[1] = by_x * b + by_y * (normal[2] * a - normal[0] * c)
    shear[2] = by_x * c + by_y * (normal[0] * b - normal[1] * a)


@inner
def deviations(
    cells: Ints,
    total: float,
    factor: NDArray[np.float32],
    prior: Floats,
    numbers: Floats,
    picked: Floats,
    moved: Floats,
    row: Any,
) -> None:
    """Set the covariance of place and force, as a `Contact` has it, and deviations of both."""
    columns, pitch, x, y = int(numbers[COLUMNS]), numbers[PITCH], row["x"], row["y"]
    stride = (len(cells) - 1) // CELLS + 1
    used = (len(cells) - 1) // stride + 1
    moved[:3] = 0.0
    for index in range(used):
        cell = cells[index * stride]
        dx, dy = cell % columns - x, cell // columns - y
        picked[0, index], picked[1, index] = dx, dy
        for taxel in range(factor.shape[1]):
            value = factor[cell, taxel]
            moved[0, taxel] += value
            moved[1, taxel] += dx * value
            moved[2, taxel] += dy * value
    covariance = row["covariance"]
    for number in range(6):
        covariance[number] = 0.0
    sign = 1.0 if numbers[SIGN] > 0.0 else -1.0
    for taxel in range(factor.shape[1]):
        one, along, across = moved[0, taxel], moved[1, taxel], moved[2, taxel]
        add_products(covariance, sign * one, sign * along, sign * across, one, along, across)
    if numbers[SIGN] < 0.0:
        for index in range(used):
            x, y = picked[0, index], picked[1, index]
            one = 0.5 * prior[0, 0]
            along, across = one * x, one * y
            for other in range(index):
                dx, dy = picked[0, other], picked[1, other]
                value = prior[int(abs(y - dy) + 0.5), int(abs(x - dx) + 0.5)]
                one += value
                along += value * dx
                across += value * dy
            add_products(covariance, 2.0 * one, 2.0 * along, 2.0 * across, 1.0, x, y)
    share = len(cells) / used
    newtons, metres = share * numbers[AREA], share * pitch / total
    for number in range(6):
        covariance[number] *= newtons if number >= X_FORCE else metres
        covariance[number] *= newtons if number == FORCE_FORCE else metres
    force = total * numbers[AREA] * numbers[FORCE_PART]
    covariance[XX] = max(covariance[XX], 0.0) + numbers[PLACE] * numbers[PLACE]
    covariance[YY] = max(covariance[YY], 0.0) + numbers[PLACE] * numbers[PLACE]
    covariance[FORCE_FORCE] = max(covariance[FORCE_FORCE], 0.0) + force * force
    state_deviations(row)


@inner
def add_products(
    covariance: Any, one: float, x: float, y: float, other: float, its_x: float, its_y: float
) -> None:
    """Add the products of (x, y, one) and of another such triple, half of the mixed ones each."""
    covariance[XX] += x * its_x
    covariance[XY] += 0.5 * (x * its_y + y * its_x)
    covariance[YY] += y * its_y
    covariance[X_FORCE] += 0.5 * (x * other + one * its_x)
    covariance[Y_FORCE] += 0.5 * (y * other + one * its_y)
    covariance[FORCE_FORCE] += one * other


@inner
def state_deviations(row: Any) -> None:
    """Set one standard deviation of the force, and of the place along either tangent."""
    covariance = row["covariance"]
    row["force_std"] = np.sqrt(covariance[FORCE_FORCE])
    row["place_std"] = np.sqrt(0.5 * (covariance[XX] + covariance[YY]))


@njit
def number_rows(memory: TrackMemory, many: int, now: int, rows: Any) -> None:
    """Go on to a reading whose contacts are the first `many` rows, and write what is known of them.

    Rows are of `CONTACT`; a covariance that is not known is that of the deviations, and those are
    the gate's floor and `FORCE_FLOOR` where nothing is known.
    """
    for place in range(many):
        row, contact, total = rows[place], memory.contacts[place], 0.0
        mean, covariance, stated = contact.mean, contact.covariance, row["covariance"]
        mean[0], mean[1], mean[2] = row["x"], row["y"], row["normal_force"]
        place_std = row["place_std"] if np.isfinite(row["place_std"]) else memory.rules[0].floor
        force_std = row["force_std"] if np.isfinite(row["force_std"]) else FORCE_FLOOR * mean[2]
        for number in range(6):
            total += stated[number]
        for i in range(3):
            for j in range(3):
                number = max(i, j) * (max(i, j) + 1) // 2 + min(i, j)
                own = (place_std**2 if i < 2 else force_std**2) if i == j else 0.0
                covariance[i, j] = FLOORS[i, j] + (stated[number] if np.isfinite(total) else own)
    track(memory, many, now)
    for place in range(memory.words[TOP]):
        known = memory.tracks[place]
        if known.column >= 0:
            row, mean = rows[known.column], known.mean
            row["track"], row["age"] = known.number, 1e-9 * (memory.words[NOW] - known.made)
            row["speed"] = np.hypot(mean[3], mean[4])
