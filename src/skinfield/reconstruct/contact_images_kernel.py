"""Kernels of contact images: what taxels read of a body, its poses, and its pressure.

The body's pressure lies on a square lattice of its own, and so does what it adds to the readings
beyond first order; what a taxel reads of a cell depends on their distance alone.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from skinfield.compiled import inner, njit
from skinfield.errors import Floats

FAST = {"reassoc", "contract", "nsz", "arcp"}
Singles = NDArray[np.float32]
ONWARDS = 0.7  # of its last step, that a body is expected to go on
FARTHEST, WIDEST = 0.7e-3, 0.07  # m and rad, that a pose moves in one step
ZERO, TINY, ONE = np.float32(0.0), np.float32(1e-9), np.uint32(1)
FAINT = 2e-3  # of the highest charge beyond first order: cells that have less are left out


class Lattice(NamedTuple):
    """Cells of a body, and what a taxel reads of one.

    Attributes
    ----------
    x, y : (J,) arrays, m
        Of the cells, row by row, in the body's frame.
    columns : int
    taxels : (L, 2) array, m
    first, second : (M,), (M',) arrays
        Reading of a cell's pressure (per unit), and of its charge beyond first order, by distance;
        0 from the end on.
    step : float, m
        Between the distances of the tables.
    """

    x: Singles
    y: Singles
    columns: int
    taxels: Floats
    first: Singles
    second: Singles
    step: float


class Batch(NamedTuple):
    """Readings of a body, up to N of them, each linear about a pose and a scale of its own.

    A reading is s A x + J d, with d the rest of scale and pose: a standard normal vector about
    `offset`, in units of `spread`. So its whitened rest e counts as e' (I + J J')^-1 e, whose root
    is I - U' c U with orthonormal rows U: `rows`, `data` and `rest` are those of that root.

    Attributes
    ----------
    raw, white : (N, L) arrays
        Readings, and one over their noise, 0 where there is none.
    poses, moved : (N, 3) arrays, m, m, rad
        Where each is linear, and how far it has come since.
    scales, grown : (N,) arrays
        The same of the force's scale.
    known : (N,) bool array
        Whose pose is given.
    rows : (J, N, L) array
        Of a cell's pressure.
    data, rest : (N, L) arrays
        rest = scale * rows * pressure - data.
    along, basis : (N, 4, L) arrays
        J', scale first, and U.
    shrink, offset, spread : (N, 4) arrays
        c, and the mean and unit of d.
    fields : (3, J) array
        Pressure, and the charge beyond first order of two more orders.
    pressure : (J,) array
    """

    raw: Floats
    white: Floats
    poses: Floats
    moved: Floats
    scales: Floats
    grown: Floats
    known: NDArray[np.bool_]
    rows: Singles
    data: Singles
    rest: Singles
    along: Floats
    basis: Singles
    shrink: Singles
    offset: Floats
    spread: Floats
    fields: Floats
    pressure: Singles


class Prior(NamedTuple):
    """What is known of pressures, poses and forces without any reading.

    Attributes
    ----------
    total, compact, low : float
        Weight of the pressure's sum, and of its logarithm above `low`: few cells rather than many.
    edges, smooth : float
        Weight of the total variation; differences below which it is a square.
    step, bend : (3,) arrays, m, m, rad
        Of one reading's pose about that before, and about where their motion goes on to.
    force : float
        Of one reading's scale about that before.
    """

    total: float
    compact: float
    low: float
    edges: float
    smooth: float
    step: Floats
    bend: Floats
    force: float


@inner(inline="always")
def _at(taxels: Floats, row: int, pose: Floats) -> tuple[float, float]:
    """Place of a taxel in the body's frame."""
    right, ahead = taxels[row, 0] - pose[0], taxels[row, 1] - pose[1]
    cos, sin = math.cos(pose[2]), math.sin(pose[2])
    return cos * right + sin * ahead, cos * ahead - sin * right


@njit(fastmath=FAST)
def fill(lattice: Lattice, pose: Floats, white: Floats, rows: Singles) -> None:
    """Whitened readings of each cell, into `rows` (J, L)."""
    table, per, count = lattice.first, np.float32(1.0 / lattice.step), len(lattice.taxels)
    reach = np.float32(((len(table) - 2) * lattice.step) ** 2)
    held = np.empty((3, count), np.float32)
    for k in range(count):
        held[0, k], held[1, k] = _at(lattice.taxels, k, pose)
        held[2, k] = white[k]
    tx, ty, weight = held[0], held[1], held[2]
    rows[:] = ZERO
    for j in range(len(lattice.x)):
        x, y = lattice.x[j], lattice.y[j]
        for k in range(count):
            u, v = tx[k] - x, ty[k] - y
            square = u * u + v * v
            if square < reach:
                place = np.float32(math.sqrt(square)) * per
                i = np.uint32(place)
                near = table[i]
                slope = table[i + ONE] - near
                rows[j, k] = weight[k] * (near + (place - np.float32(i)) * slope)


@njit(fastmath=FAST)
def look(lattice: Lattice, pose: Floats, fields: Floats, out: Floats, slopes: Floats) -> None:
    """Readings (3, L) of the fields (3, J) of order 1 to 3, and slopes (3, 3, L) along the pose."""
    size, count, far, faint = len(lattice.x), 0, 0, FAINT * np.abs(fields[1]).max()
    held = np.empty((7, size), np.float32)
    for j in range(size):
        if fields[0, j] != 0.0:
            held[0, count], held[1, count], held[2, count] = (
                lattice.x[j],
                lattice.y[j],
                fields[0, j],
            )
            count += 1
        if abs(fields[1, j]) > faint:
            held[3, far], held[4, far] = lattice.x[j], lattice.y[j]
            held[5, far], held[6, far] = fields[1, j], fields[2, j]
            far += 1
    cos, sin = math.cos(pose[2]), math.sin(pose[2])
    sums, more = np.empty((2, 3), np.float32), np.empty((2, 3), np.float32)
    for k in range(len(lattice.taxels)):
        tx, ty = _at(lattice.taxels, k, pose)
        sums[:], more[:] = ZERO, ZERO
        _add(lattice.first, lattice.step, tx, ty, held[0:3, :count], sums[:1])
        _add(lattice.second, lattice.step, tx, ty, held[3:7, :far], more)
        for order in range(3):
            value, gx, gy = sums[0] if order == 0 else more[order - 1]
            out[order, k] = value
            slopes[order, 0, k] = sin * gy - cos * gx
            slopes[order, 1, k] = -sin * gx - cos * gy
            slopes[order, 2, k] = gx * ty - gy * tx


@inner(fastmath=FAST)
def _add(table: Singles, step: float, x: float, y: float, held: Singles, sums: Singles) -> None:
    """Reading and its slopes along x and y, of one or two fields (2 + F, count), to (F, 3)."""
    per, tx, ty = np.float32(1.0 / step), np.float32(x), np.float32(y)
    reach = np.float32(((len(table) - 2) * step) ** 2)
    for j in range(held.shape[1]):
        u, v = tx - held[0, j], ty - held[1, j]
        square = u * u + v * v
        if square < reach:
            distance = np.float32(math.sqrt(square)) + TINY
            place = distance * per
            i = np.uint32(place)
            slope = table[i + ONE] - table[i]
            near = table[i] + (place - np.float32(i)) * slope
            slope *= per / distance
            for m in range(len(sums)):
                p = held[2 + m, j]
                sums[m, 0] += p * near
                sums[m, 1] += p * slope * u
                sums[m, 2] += p * slope * v


@inner
def _expected(batch: Batch, t: int, count: int, prior: Prior, pose: Floats, spread: Floats) -> None:
    """Pose of a reading without itself, and how well that is known; 0: it is given."""
    size = len(batch.raw)
    before, earlier = (t - 1) % size, (t - 2) % size
    for k in range(3):
        pose[k] = batch.poses[t, k] + batch.moved[t, k]
        spread[k] = 0.0 if batch.known[t] else prior.step[k]
        if t == (count - 1) % size and not batch.known[t] and count > 2:
            last = batch.poses[before, k] + batch.moved[before, k]
            pose[k] = last + ONWARDS * (last - batch.poses[earlier, k] - batch.moved[earlier, k])


@inner
def settle(
    lattice: Lattice,
    fields: Floats,
    white: Floats,
    raw: Floats,
    pose: Floats,
    scale: float,
    centre: Floats,
    spread: Floats,
    steps: int,
    rest: Floats,
    along: Floats,
) -> tuple[float, float]:
    """Most probable pose (in place) and scale of a reading, by steps of Gauss and Newton.

    Parameters
    ----------
    centre, spread : (3,) arrays
        Of the pose before the reading; a spread of 0: it is known.
    rest : (L,) array
        Receives the reading less what is beyond first order.
    along : (4, L) array
        Receives the whitened slopes along the logarithm of the scale, and along the pose.

    Returns
    -------
    scale : float
    misfit : float
        Mean square of the whitened rest.
    """
    y, slopes = np.zeros((3, len(raw))), np.zeros((3, 3, len(raw)))
    size = 4 if spread[0] > 0.0 else 1
    misfit, at_first, left = 0.0, scale, raw.copy()
    for step in range(steps + 1):
        if step == 0 or size > 1:
            look(lattice, pose, fields, y, slopes)
        s = scale
        left = white * (raw - s * (y[0] + s * (y[1] + s * y[2])))
        misfit = (left * left).mean()
        along[0] = (white * s) * (y[0] + s * (2.0 * y[1] + s * 3.0 * y[2]))
        for k in range(3):
            along[1 + k] = (white * s) * (slopes[0, k] + s * (slopes[1, k] + s * slopes[2, k]))
        if step == steps:
            break
        part = along[:size]
        normal, right = part @ part.T, part @ left
        normal[0, 0] += 1e-9
        for k in range(1, size):
            weight = 1.0 / spread[k - 1] ** 2
            normal[k, k] += weight
            right[k] -= weight * (pose[k - 1] - centre[k - 1])
        change = np.linalg.solve(normal, right)
        far = 1.0
        for k in range(1, size):
            far = max(far, abs(change[k]) / (WIDEST if k == 3 else FARTHEST))
            pose[k - 1] += change[k] / far
        grown = min(max(change[0] / far, -0.5), 0.5)
        scale = min(max(scale * (1.0 + grown), 0.1 * at_first), 10.0 * at_first)
    rest[:] = raw - scale * scale * (y[1] + scale * y[2])
    return scale, misfit


@inner(fastmath=FAST)
def _into_root(batch: Batch, t: int, size: int, along: Floats, white: Floats, rest: Floats) -> None:
    """Rows and data of a reading, as their root has them: see `Batch`."""
    part = np.ascontiguousarray(along[:size])
    values, turn = np.linalg.eigh(part @ part.T)
    batch.basis[t] = ZERO
    batch.shrink[t] = ZERO
    batch.along[t] = 0.0
    batch.along[t, :size] = part
    for i in range(size):
        value = max(values[i], 1e-12)
        batch.shrink[t, i] = 1.0 - 1.0 / math.sqrt(1.0 + value)
        for k in range(len(white)):
            total = 0.0
            for m in range(size):
                total += turn[m, i] * part[m, k]
            batch.basis[t, i, k] = total / math.sqrt(value)
    scale = np.float32(batch.scales[t])
    for k in range(len(white)):
        total = white[k] * rest[k]
        for m in range(size):
            total -= batch.offset[t, m] * part[m, k]
        batch.data[t, k] = total
    _rooted(batch.data[t], batch.basis[t], batch.shrink[t], size)
    for k in range(len(white)):
        batch.rest[t, k] = -batch.data[t, k]
    for j in range(len(batch.pressure)):
        row = batch.rows[j, t]
        _rooted(row, batch.basis[t], batch.shrink[t], size)
        p = batch.pressure[j]
        if p != ZERO:
            for k in range(len(white)):
                batch.rest[t, k] += scale * p * row[k]


@inner(fastmath=FAST, inline="always")
def _rooted(row: Singles, basis: Singles, shrink: Singles, size: int) -> None:
    for i in range(size):
        total = np.float32(0.0)
        for k in range(len(row)):
            total += basis[i, k] * row[k]
        total *= shrink[i]
        for k in range(len(row)):
            row[k] -= total * basis[i, k]


@njit
def visit(lattice: Lattice, batch: Batch, t: int, count: int, prior: Prior, steps: int) -> float:
    """Make a reading linear where its pose and scale have come to; its misfit."""
    centre, spread = np.empty(3), np.empty(3)
    _expected(batch, t, count, prior, centre, spread)
    white, first = batch.white[t], count == 1
    batch.poses[t] += batch.moved[t]
    batch.scales[t] += batch.grown[t]
    batch.moved[t], batch.grown[t] = 0.0, 0.0
    expected = batch.scales[t]
    rest, along = np.empty(len(white)), np.empty((4, len(white)))
    batch.scales[t], misfit = settle(
        lattice, batch.fields, white, batch.raw[t], batch.poses[t], batch.scales[t], centre,
        spread, steps, rest, along,
    )  # fmt: skip
    fill(lattice, batch.poses[t], white, batch.rows[:, t])
    scale, size = batch.scales[t], 4 if spread[0] > 0.0 else 1
    batch.spread[t, 0] = 1e-6 if first else prior.force * expected
    batch.offset[t, 0] = 0.0 if first else (expected - scale) / batch.spread[t, 0]
    along[0] *= batch.spread[t, 0] / scale
    for k in range(1, size):
        batch.spread[t, k] = spread[k - 1]
        batch.offset[t, k] = (centre[k - 1] - batch.poses[t, k - 1]) / spread[k - 1]
        along[k] *= spread[k - 1]
    _into_root(batch, t, size, along, white, rest)
    return misfit


@njit
def follow(batch: Batch, count: int, prior: Prior, size: int) -> None:
    """How far scales and poses come by the pressure as it is now, all of them as one motion.

    With `size` 1 poses are given, and scales alone are sought.
    """
    kept = min(count, len(batch.raw))
    normal, right = np.zeros((kept * size, kept * size)), np.zeros(kept * size)
    slots = np.arange(count - kept, count) % len(batch.raw)
    for i in range(kept):
        _tell(batch, slots[i], size, i, normal, right)
        for k in range(size):
            _join(batch, slots, i, k, size, prior, normal, right)
    change = np.linalg.solve(normal, right).reshape(kept, size)
    for i in range(kept):
        t, far = slots[i], 1.0
        for k in range(1, size):
            far = max(far, abs(change[i, k]) / (WIDEST if k == 3 else FARTHEST))
        for k in range(1, size):
            batch.moved[t, k - 1] = change[i, k] / far
        most = 0.3 * batch.scales[t]
        batch.grown[t] = min(max(change[i, 0], -most), most)


@inner
def _tell(batch: Batch, t: int, size: int, i: int, normal: Floats, right: Floats) -> None:
    """Add what a reading itself tells about its scale and pose."""
    held = 1 if batch.known[t] else size
    rest = batch.rest[t].astype(np.float64)
    for k in range(held):
        basis = batch.basis[t, k].astype(np.float64)
        shrink = float(batch.shrink[t, k])
        rest += (shrink / (1.0 - shrink) * (basis @ rest)) * basis
    for k in range(held):
        rest -= batch.offset[t, k] * batch.along[t, k]
    for k in range(held):
        a = i * size + k
        right[a] -= (batch.along[t, k] @ rest) / batch.spread[t, k]
        for m in range(held):
            shared = batch.along[t, k] @ batch.along[t, m]
            normal[a, i * size + m] += shared / (batch.spread[t, k] * batch.spread[t, m])
    for k in range(held, size):
        normal[i * size + k, i * size + k] += 1.0


@inner
def _join(
    batch: Batch, slots: NDArray[np.int64], i: int, k: int, size: int, prior: Prior,
    normal: Floats, right: Floats,
) -> None:  # fmt: skip
    """Add how far a scale, or a coordinate of a pose, may be from those before."""
    for order in range(3):  # where it begins, its steps, and what differs from step to step
        if (order == 0) != (i == 0) or order > i or (order == 2 and k == 0):
            continue
        factor = (1.0, -1.0, 0.0) if order < 2 else (1.0, -2.0, 1.0)
        spread = prior.force if k == 0 else prior.step[k - 1]
        if order == 2:
            spread = prior.bend[k - 1]
        away = 0.0
        for m in range(order + 1):
            t = slots[i - m]
            away += factor[m] * (batch.scales[t] if k == 0 else batch.poses[t, k - 1])
        if order == 0:
            away = away - 1.0 if k == 0 else 0.0
        for m in range(order + 1):
            a = (i - m) * size + k
            if k > 0 and batch.known[slots[i - m]]:
                continue
            right[a] -= factor[m] * away / spread**2
            for n in range(order + 1):
                if not (k > 0 and batch.known[slots[i - n]]):
                    normal[a, (i - n) * size + k] += factor[m] * factor[n] / spread**2


@njit
def farthest(batch: Batch, kept: int) -> int:
    """Reading that has come farthest from where it is linear."""
    best, most = 0, -1.0
    for t in range(kept):
        way = abs(batch.grown[t]) / batch.scales[t] * 3.0
        for k in range(3):
            way = max(way, abs(batch.moved[t, k]) / (0.1 if k == 2 else 1e-3))
        if way > most:
            best, most = t, way
    return best


@inner(fastmath=FAST)
def _couple(
    columns: int, pressure: Singles, edges: np.float32, smooth: np.float32, coupling: Singles
) -> None:
    """Curvature (J,) of the total variation, of each cell to those after it along x and y."""
    cells = len(pressure)
    for j in range(cells):
        dx = (pressure[j + 1] if (j + 1) % columns else ZERO) - pressure[j]
        dy = (pressure[j + columns] if j + columns < cells else ZERO) - pressure[j]
        coupling[j] = edges / math.sqrt(dx * dx + dy * dy + smooth * smooth)


@njit(fastmath=FAST)
def sweep(
    columns: int, rows: Singles, rest: Singles, scales: Singles, pressure: Singles, kept: int,
    prior: Prior, sweeps: int, whole: bool,
) -> None:  # fmt: skip
    """Lower the objective cell by cell, in place: coordinate descent.

    The total variation and the logarithm are squares and planes above themselves, renewed in each
    sweep (half-quadratic; Geman and Reynolds, IEEE PAMI 14, 1992), so that no step goes up.

    Parameters
    ----------
    rows : (J, N, L) array
    rest : (N, L) array
        scale * rows * pressure - data; is kept up.
    scales : (N,) array
    pressure : (J,) array
    kept : int
        Readings that there are.
    prior : Prior
    sweeps : int
    whole : bool
        Look at cells that border on no pressed one as well, in every fourth sweep.
    """
    total, compact, low = np.float32(prior.total), np.float32(prior.compact), np.float32(prior.low)
    edges, smooth = np.float32(prior.edges), np.float32(prior.smooth)
    cells, _, taxels = rows.shape
    height = cells // columns
    curvature = np.full(cells, -1.0, np.float32)
    coupling = np.zeros(cells, np.float32)
    for turn in range(sweeps):
        _couple(columns, pressure, edges, smooth, coupling)
        for i in range(cells):
            j = i if turn % 2 == 0 else cells - 1 - i
            r, c, p = j // columns, j % columns, pressure[j]
            left = pressure[j - 1] if c > 0 else ZERO
            right = pressure[j + 1] if c + 1 < columns else ZERO
            below = pressure[j - columns] if r > 0 else ZERO
            above = pressure[j + columns] if r + 1 < height else ZERO
            alone = left + right + below + above == ZERO
            if alone and p == ZERO and not (whole and turn % 4 == 0):
                continue
            w = coupling[j]
            wl = coupling[j - 1] if c > 0 else w
            wb = coupling[j - columns] if r > 0 else w
            slope = total + compact * low / (p + low)
            slope += w * (2.0 * p - right - above) + wl * (p - left) + wb * (p - below)
            square = ZERO
            for t in range(kept):
                g = ZERO
                for k in range(taxels):
                    g += rows[j, t, k] * rest[t, k]
                slope += scales[t] * g
                if curvature[j] < ZERO:
                    g = ZERO
                    for k in range(taxels):
                        g += rows[j, t, k] * rows[j, t, k]
                    square += scales[t] * scales[t] * g
            if curvature[j] < ZERO:
                curvature[j] = square
            change = max(-slope / (curvature[j] + 2.0 * w + wl + wb), -p)
            if change != 0.0:
                pressure[j] = p + change
                for t in range(kept):
                    f = np.float32(scales[t] * change)
                    for k in range(taxels):
                        rest[t, k] += f * rows[j, t, k]
