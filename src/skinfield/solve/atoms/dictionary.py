"""Dictionary of templates of single contacts all over a patch: where a search starts.

Templates stand in blocks of neighbouring places, each with the taxels that see any of them. A few
of each block are scored first; the others only where one of these agrees with the readings, which
of a skin at rest hardly any does.
"""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from skinfield.compiled import inner
from skinfield.errors import Floats, Ints
from skinfield.solve.atoms.atom_readings import PARAMETERS, predict
from skinfield.solve.atoms.fit_kernel import FitModel
from skinfield.solve.atoms.table import Tables
from skinfield.solve.tiles import SIDE, Tiles, aligned_blocks
from skinfield.solve.tiles_kernel import LANES, apply_tiles

SPACING = 0.5  # thicknesses between places
BLOCK = 4  # places along the side of a block
RADII = (0.4, 0.8, 1.5, 2.6)  # thicknesses
MARGIN = 1.5  # thicknesses beyond the outermost pads
SHALLOW = 0.15  # strain of the gap at the axis at which templates are made
WIDTH = 8  # numbers of a vector register
SAME = 1e-5  # part of a score: what single precision cannot tell is the same, and the first counts
FAINTEST = 0.02  # of the strongest template: below, a place is not seen
UNSEEN = 0.02  # of a template's norm: taxels that read less of it are left out
FIRST = 0.8  # thicknesses: radius of the templates that are scored first
NEARLY = 0.9  # of the least score: what one of these must reach
WORSE = 0.4  # of the best score: templates that agree less are no starts


class FirstTemplates(NamedTuple):
    """Templates that are scored first, in tiles of 16; see `tiles_kernel`.

    Attributes
    ----------
    values : (N, 16) float32 array
    taxels : (N,) int32 array
    firsts : (T + 1,) int32 array
    cells : (T,) int32 array
    blocks : (16 T,) int array
        To which block of all templates each belongs; where there is none, the template is 0.
    """

    values: NDArray[np.float32]
    taxels: NDArray[np.int32]
    firsts: NDArray[np.int32]
    cells: NDArray[np.int32]
    blocks: Ints

    @classmethod
    def of(cls, rows: Floats, places: Floats, blocks: Ints) -> "FirstTemplates":
        """Tiles of templates (F, L) that stand at places (F, 2), those side by side together."""
        tile = np.floor(places / (2 * BLOCK * SPACING)).astype(int)
        order = np.lexsort((tile[:, 0], tile[:, 1]))
        filled = np.pad(rows[order], [(0, -len(order) % LANES), (0, 0)])
        tiles = Tiles.of(filled, (len(filled) // SIDE, SIDE), cut=0.0)
        values = aligned_blocks(len(tiles.values), np.dtype(np.float32))
        values[:] = tiles.values
        taxels, firsts, cells = (np.array(a) for a in (tiles.taxels, tiles.firsts, tiles.cells))
        owners = np.pad(blocks[order], (0, len(filled) - len(order)))
        return cls(values, taxels, firsts, cells, owners)


class Templates(NamedTuple):
    """Whitened templates of balls, in blocks.

    Attributes
    ----------
    taxels : (B, S) int array
        That see a block; beyond their number the first, for which templates are 0.
    firsts : (B + 1,) int array
        First template of each block.
    first : FirstTemplates
    templates : (T, S) float32 array
        Of norm 1 over the taxels of the block.
    norms : (T,) array
        Before that, per newton.
    atoms : (T, 8) array
        Parameters of each, with the force at which it was made.
    noise : (L,) array, in the quantity's unit
        Deviations of the taxels, by which they are whitened.
    """

    taxels: Ints
    firsts: Ints
    first: FirstTemplates
    templates: NDArray[np.float32]
    norms: Floats
    atoms: Floats
    noise: Floats


class StartMemory(NamedTuple):
    """Room in which starts are sought.

    Attributes
    ----------
    scores : (T,) float32 array
    listed : (T,) int array
    local : (S,) float32 array
    highest : (B,) array
        Of the scores of those of each block that are scored first.
    single : (1, L) float32 array
    first : (1, F) float32 array
        Scores of what is scored first.
    starts : (most, 8) array
        What was found.
    """

    scores: NDArray[np.float32]
    listed: Ints
    local: NDArray[np.float32]
    highest: Floats
    single: NDArray[np.float32]
    first: NDArray[np.float32]
    starts: Floats

    @classmethod
    def of(cls, bank: Templates, most: int, taxels: int) -> "StartMemory":
        """Room for a dictionary, and so many starts."""
        count = len(bank.norms)
        return cls(
            np.zeros(count, np.float32),
            np.zeros(count, np.int64),
            np.zeros(bank.templates.shape[1], np.float32),
            np.zeros(len(bank.taxels)),
            np.zeros((1, taxels), np.float32),
            np.zeros((1, len(bank.first.blocks)), np.float32),
            np.zeros((most, PARAMETERS)),
        )


@inner(fastmath=True, forceinline=True, _nrt=False)
def _product(one: NDArray[np.float32], other: NDArray[np.float32]) -> float:
    total = np.float32(0.0)
    for i in range(len(one)):
        total += one[i] * other[i]
    return float(total)


@inner(forceinline=True, _nrt=False)
def _take(bank: Templates, block: int, residual: Floats, local: NDArray[np.float32]) -> None:
    """Copy what the taxels of a block read."""
    for i in range(len(local)):
        local[i] = residual[bank.taxels[block, i]]


@inner(fastmath=True, _nrt=False)
def _highest(scores: NDArray[np.float32]) -> float:
    best = np.float32(0.0)
    for score in scores:
        best = max(best, score)
    return float(best)


@inner(_nrt=False)
def best_score(bank: Templates, memory: StartMemory, residual: Floats) -> float:
    """Highest agreement of a whitened residual (L,) with the first templates of all blocks."""
    single, scores, first = memory.single, memory.first, bank.first
    for taxel in range(len(residual)):
        single[0, taxel] = residual[taxel]
    apply_tiles(first.values, first.taxels, first.firsts, first.cells, SIDE, single, scores)
    return _highest(scores[0])


@inner(_nrt=False)
def find_starts(
    bank: Templates, memory: StartMemory, residual: Floats, most: int, least: float
) -> int:
    """Write atoms at the best places, each with the force that explains most; how many there are.

    Parameters
    ----------
    residual : (L,) array
        Whitened; 0 where a taxel is not heard.
    most : int
        Starts.
    least : float
        Standard deviations; where no template agrees with the residual by more, there is no start.
    """
    scores, listed, local, highest = memory.scores, memory.listed, memory.local, memory.highest
    count, best = 0, best_score(bank, memory, residual)
    if not best > NEARLY * least:
        return 0
    for block in range(len(highest)):
        highest[block] = 0.0
    for t in range(len(bank.first.blocks)):
        block = bank.first.blocks[t]
        highest[block] = max(highest[block], memory.first[0, t])
    gate = max(NEARLY * least, WORSE * best)
    for block in range(len(highest)):
        if highest[block] < gate:
            continue
        _take(bank, block, residual, local)
        for t in range(bank.firsts[block], bank.firsts[block + 1]):
            score = _product(bank.templates[t], local)
            if score > WORSE * best:
                scores[count], listed[count] = score, t
                count += 1
                best = max(best, score)
    found = 0
    if not best > least:
        return found
    while found < most:
        value, at = WORSE * best, -1
        for i in range(count):
            if scores[i] > (1.0 + SAME) * value:
                value, at = scores[i], i
        if at < 0:
            break
        start, chosen = memory.starts[found], bank.atoms[listed[at]]
        for k in range(PARAMETERS):
            start[k] = chosen[k]
        start[2] = np.log(max(value / bank.norms[listed[at]], 1e-9))
        found += 1
        for i in range(count):  # none beside a better one
            other = bank.atoms[listed[i]]
            beside = abs(chosen[0] - other[0]) < NEAR and abs(chosen[1] - other[1]) < NEAR
            if beside and abs(chosen[3] - other[3]) < 1.0:
                scores[i] = 0.0
    return found


NEAR = 1.2 * SPACING


def make_templates(model: FitModel, white: Floats) -> Templates:
    """Templates on a lattice over the taxels; `white` (L,) is one over their noise."""
    taxels = model.taxels
    low, high = taxels.min(axis=0) - MARGIN, taxels.max(axis=0) + MARGIN
    columns, rows = (np.ceil((high - low) / SPACING).astype(int) + 1).tolist()
    blocks = []
    for row in range(0, rows, BLOCK):
        for column in range(0, columns, BLOCK):
            x, y = np.meshgrid(
                low[0] + SPACING * np.arange(column, min(column + BLOCK, columns)),
                low[1] + SPACING * np.arange(row, min(row + BLOCK, rows)),
            )
            blocks.append(_block(model, white, np.column_stack([x.ravel(), y.ravel()])))
    faintest = FAINTEST * max(float(seen.max()) for _, _, seen in blocks)
    kept = [_visible(atoms, rows, seen > faintest) for atoms, rows, seen in blocks]
    kept = [block for block in kept if len(block[0])]
    widest = WIDTH * -(-max(len(block[1]) for block in kept) // WIDTH)

    def filled(rows: NDArray[Any]) -> NDArray[Any]:
        return np.pad(rows, [(0, 0), (0, widest - rows.shape[1])])

    return Templates(
        taxels=np.concatenate([filled(near[None]) for _, near, _, _ in kept]).astype(np.int64),
        firsts=np.cumsum([0, *(len(atoms) for atoms, _, _, _ in kept)]),
        first=_first(kept, len(white)),
        templates=np.ascontiguousarray(  # whatever order the parts have: rows are read
            np.concatenate([filled(part) for _, _, part, _ in kept]), dtype=np.float32
        ),
        norms=np.concatenate([norms for _, _, _, norms in kept]),
        atoms=np.concatenate([atoms for atoms, _, _, _ in kept]),
        noise=1.0 / white,
    )


def _first(blocks: list[tuple[Floats, Ints, Floats, Floats]], taxels: int) -> FirstTemplates:
    """What is scored first of each block, see `_visible`."""
    rows, places, owners = [], [], []
    for number, (atoms, near, part, _) in enumerate(blocks):
        few = _is_few(atoms)
        own = np.zeros((int(few.sum()), taxels))
        own[:, near] = part[few]
        rows.append(own)
        places.append(atoms[few, :2])
        owners.append(np.full(len(own), number))
    parts = (np.concatenate(each) for each in (rows, places, owners))
    return FirstTemplates.of(*parts)


def _is_few(atoms: Floats) -> NDArray[np.bool_]:
    """Which of a block's templates (T, 8) are scored first: at each second place each way."""
    lowest = atoms[:, :2].min(axis=0, initial=np.inf)
    place = np.rint((atoms[:, :2] - lowest) / SPACING).astype(int)
    few = (place % 2 == 1).all(axis=1) & np.isclose(atoms[:, 3], np.log(FIRST))
    return np.asarray(few if few.any() else np.ones(len(atoms), np.bool_))


def _block(model: FitModel, white: Floats, places: Floats) -> tuple[Floats, Floats, Floats]:
    """Atoms (T, 8) at some places, what they are read as (T, L), whitened, and how well per N."""
    tables = model.tables
    atoms = np.zeros((len(RADII) * len(places), PARAMETERS))
    atoms[:, :2] = np.tile(places, (len(RADII), 1))
    atoms[:, 3] = np.repeat(np.log(RADII), len(places))
    logs = [_shallow_log_force(tables, float(np.log(radius))) for radius in RADII]
    atoms[:, 2] = np.repeat(logs, len(places))
    rows = np.zeros((len(atoms), len(white)))
    family, jacobian = np.zeros(1, dtype=np.int64), np.empty((1, PARAMETERS, len(white)))
    for atom, row in zip(atoms, rows, strict=True):
        predict(atom[None], family, model.taxels, tables, row, jacobian)
    rows *= white
    return atoms, rows, np.linalg.norm(rows, axis=1) * np.exp(-atoms[:, 2])


def _visible(
    atoms: Floats, rows: Floats, seen: NDArray[np.bool_]
) -> tuple[Floats, Ints, Floats, Floats]:
    """Atoms that are seen, taxels that see them, templates over these and their norms per N."""
    atoms, rows = atoms[seen], rows[seen]
    norms = np.linalg.norm(rows, axis=1)
    near = np.flatnonzero((np.abs(rows) > UNSEEN * norms[:, None]).any(axis=0))
    part = rows[:, near]
    size = np.linalg.norm(part, axis=1)
    return atoms, near, part / size[:, None], size * np.exp(-atoms[:, 2])


def _shallow_log_force(tables: Tables, log_radius: float) -> float:
    if not tables.strain.size:
        return 0.0
    from scipy.ndimage import map_coordinates

    place = (log_radius - tables.first_log) / tables.log_step
    log_strain = map_coordinates(tables.strain[0], [[place]], order=3, prefilter=False)[0]
    return float(np.log(SHALLOW) - log_strain)
