"""Kinds of patches: those that are the same to a solver share what is prepared for one of them."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from skinfield.elastic import Layer
from skinfield.errors import Floats, InputError, as_floats, check_shape
from skinfield.reconstruct.multigrid import Rungs
from skinfield.skin import Patch, Skin
from skinfield.solve import Operator
from skinfield.solve.tiles import Tiles

Singles = NDArray[np.float32]
PROOF = 1e-4  # of each taxel's part in an idle test: its bound is then about 0.01 deviations
SCORES = 6  # patches whose products an idle test holds at once: `tiles_kernel.TOGETHER`


@dataclass(frozen=True, eq=False)
class IdleTest:
    """Test of all patches of a kind by tiles: what of their readings stands out of the noise.

    Attributes
    ----------
    tiles : Tiles
        Of rows of the length 1, one for each cell, for readings in units of their noise.
    dropped : (K,) float32 array
        How far each product may be off, as part of the norm of a patch's readings.
    threshold : float
        That no product of an idle patch exceeds.
    scores : (6, K) float32 array
        To work in.
    """

    tiles: Tiles
    dropped: Singles
    threshold: float
    scores: Singles

    @classmethod
    def of(cls, rows: NDArray[Any], shape: tuple[int, int], threshold: float) -> "IdleTest":
        """Test by rows (K, L) of a grid."""
        tiles = Tiles.of(rows, shape, PROOF)
        dropped = (tiles.dropped * (1.0 + 1e-6)).astype(np.float32)  # not less by its rounding
        return cls(tiles, dropped, threshold, np.zeros((SCORES, len(rows)), np.float32))

    def apply(self, white: Singles, idle: NDArray[np.bool_]) -> None:
        """Write into `idle` (P,) which of readings (P, L) without their offset are idle."""
        from skinfield.reconstruct.engine.idle_tests_kernel import idle_patches

        tiles = self.tiles
        where = tiles.values, tiles.taxels, tiles.firsts, tiles.cells, tiles.shape[1]
        idle_patches(*where, self.dropped, self.threshold, white, self.scores, idle)


CUT = 1e-3  # of each taxel's effect on the field, that a linear answer may lack
SAME = 1e-6  # of the pads' pitch: places that are one


@dataclass(frozen=True, eq=False)
class PatchKind:
    """Patches of equal geometry, layer and noise.

    Attributes
    ----------
    patches : tuple of Patch
        The first stands for all.
    layer : Layer
    noise_std : (L,) array, unit of the reading
    """

    patches: tuple[Patch, ...]
    layer: Layer
    noise_std: Floats


def kinds_of(
    skin: Skin,
    layer: Layer | Mapping[str, Layer] | None,
    noise_std: ArrayLike | Mapping[str, ArrayLike],
    typical: float,
) -> tuple[PatchKind, ...]:
    """Sort the patches of a skin by kind.

    Two are of one kind if their taxels stand at equal places of their planes, up to a shift, in
    the same order, below the same layer, with pads and noise alike.

    Parameters
    ----------
    skin : Skin
    layer : Layer, or mapping from every patch's name to one
    noise_std : float or (L,) array, or mapping from names of patches to such
        Patches that a mapping leaves out have `typical`.
    typical : float
    """
    found: list[PatchKind] = []
    for patch in skin:
        its = layer_of(patch, layer)
        noise = _noise_of(patch, noise_std, typical)
        if its.relaxation is not None:  # undoing it takes
            noise = noise / its.relaxation.relaxed_fraction
        for place, kind in enumerate(found):
            if _alike(kind, patch, its, noise):
                found[place] = PatchKind((*kind.patches, patch), its, noise)
                break
        else:
            found.append(PatchKind((patch,), its, noise))
    return tuple(found)


def check_names(name: str, given: Mapping[str, object], known: Sequence[str]) -> None:
    """Raise InputError for names that no patch has."""
    unknown = [each for each in given if each not in known]
    if unknown:
        raise InputError(
            f"{name} names {unknown[0]!r}, which is no patch, expected names among: "
            f"{', '.join(known[:8])}{', ...' if len(known) > 8 else ''}"
        )


def layer_of(patch: Patch, layer: Layer | Mapping[str, Layer] | None) -> Layer:
    """Layer of a patch; raises InputError where a mapping does not have it."""
    if isinstance(layer, Mapping):
        if patch.name not in layer:
            raise InputError(
                f"layer has no entry for patch {patch.name!r}, expected one for every patch: "
                "what lies over it is not known otherwise"
            )
        return layer[patch.name]
    return Layer() if layer is None else layer


def _noise_of(
    patch: Patch, noise_std: ArrayLike | Mapping[str, ArrayLike], typical: float
) -> Floats:
    given = noise_std.get(patch.name, typical) if isinstance(noise_std, Mapping) else noise_std
    noise = as_floats("noise_std", given)
    if noise.ndim:
        check_shape("noise_std", noise, (len(patch),), f"one per taxel of {patch.name!r}")
        return noise
    return np.full(len(patch), float(noise))


def _alike(kind: PatchKind, patch: Patch, layer: Layer, noise: Floats) -> bool:
    first = kind.patches[0]
    if len(first) != len(patch) or kind.layer != layer or first.pad_diameter != patch.pad_diameter:
        return False
    if not np.array_equal(kind.noise_std, noise):
        return False
    apart = (patch.plane - patch.plane[0]) - (first.plane - first.plane[0])
    return bool(np.abs(apart).max() <= SAME * first.pitch)


def one_skin(skin: Skin | Patch | Sequence[Patch]) -> Skin:
    """A skin, also of one patch alone."""
    if isinstance(skin, Skin):
        return skin
    if isinstance(skin, Patch):
        return Skin((skin,))
    raise InputError(
        f"skin is a {type(skin).__name__}, expected a Skin or a Patch: Skin((patch, ...)) of "
        "patches that have distinct names"
    )


MOST_SETS = 16  # of valid taxels, on one rung each, whose operators stay prepared
MOST_FILLINGS = 64  # sets of them whose maps stay at hand


class PatchGroup:
    """Prepared answers of P patches of one kind on R rungs.

    Parameters
    ----------
    index : int
        Among the groups.
    first : int
        Row of its first patch among all patches.
    kind : PatchKind
    rungs : Rungs

    Attributes
    ----------
    products : R of Tiles
        From whitened readings to the linear answer.
    fields : R arrays (P, K) float32, Pa
        Linear answers.
    operators : R Operators
        That search; none where linear.
    data : R lists of P Data
        Memory of each patch's searches, and their answers.
    offset : (2, L) array
        Weights of whitened readings in the offset that the linear answer takes them to share, and
        how far one moves them.
    idle_offset : (2, L) array
        As `offset`, where nothing touches; of searches.
    idle_test : IdleTest or None
        On the finest grid; none where linear, and where contacts are found.
    last : list of P Data
        Of the search that each patch used last, or None.
    finds_contacts : bool
        Whether searches find contacts by themselves, as rows of their data.
    """

    def __init__(self, index: int, first: int, kind: PatchKind, rungs: Rungs) -> None:
        self.index, self.first, self.kind, self.rungs = index, first, kind, rungs
        from skinfield.reconstruct.engine.idle_tests_kernel import without_offset

        steps, count, noise = rungs.steps, len(kind.patches), kind.noise_std
        self.offset = np.stack([rungs.offset_weights * noise, 1.0 / noise])
        self.products = [
            Tiles.of(self.matrix_on(rung), step.grid.shape, CUT) for rung, step in enumerate(steps)
        ]
        self.level: Singles = np.zeros((count, len(noise)), np.float32)
        self.without_offset: Any = without_offset
        self.fields: list[Singles] = [
            np.zeros((count, len(step.grid)), np.float32) for step in steps
        ]
        self.operators = [] if rungs.linear else [_search(step.operator) for step in steps]
        if self.operators and hasattr(self.operators[0], "prepare_mechanics"):
            self.operators[0].prepare_mechanics()  # its readings have deadlines
        self.data: list[list[Any]] = [
            [each.data() for _ in range(count)] for each in self.operators
        ]
        self.last: list[Any] = [None] * count
        self.finds_contacts = bool(self.data) and self.data[0][0].rows is not None
        self.idle_test: IdleTest | None = None
        if self.operators and not self.finds_contacts:
            problem, grid = self.operators[-1].problem, steps[-1].grid
            offset = problem.offset[: len(noise)]
            self.idle_offset = np.stack([offset / (1.0 + offset @ offset), offset])
            norms, rows = problem.norms, problem.unshared[:, : len(noise)]
            scale = np.divide(1.0, norms, out=np.zeros_like(norms), where=norms > 0)
            self.idle_test = IdleTest.of(rows * scale[:, None], grid.shape, problem.threshold)
        for level in self.data[1:] if self.finds_contacts else ():
            for each, coarsest in zip(level, self.data[0], strict=True):
                each.start_from(coarsest)  # one fit of all grids
        self._without = lru_cache(MOST_SETS)(self._prepared_without)
        self._filling = lru_cache(MOST_FILLINGS)(self._prepared_filling)
        every = np.ones(len(noise), np.bool_)
        for each in self.operators:
            each.without(every)  # loads what is compiled

    @property
    def count(self) -> int:
        """Number of patches."""
        return len(self.kind.patches)

    @property
    def rows(self) -> slice:
        """Its patches among all."""
        return slice(self.first, self.first + self.count)

    def answer_all(self, rung: int, white: Singles) -> None:
        """Linear answers of all patches from whitened readings (P, L)."""
        self.without_offset(white, *self.offset, self.level)
        self.products[rung].apply(self.level, self.fields[rung])

    def matrix_on(self, rung: int) -> Floats:
        """Linear answer (K, L) to whitened readings without their offset: sparser than with it."""
        matrix, weights = self.rungs.steps[rung].start.matrix, self.rungs.offset_weights
        uniform = matrix.sum(axis=1) / (1.0 - weights.sum())
        return np.asarray((matrix + np.outer(uniform, weights)) * self.kind.noise_std)

    def fill(self, white: Singles, valid: NDArray[np.bool_]) -> None:
        """Let readings of the noise 1 (L,), 0 where not `valid`, give the valid taxels' answer."""
        white[:] = self._filling(valid.tobytes()) @ white

    def _prepared_filling(self, key: bytes) -> Singles:
        noise, part = self.kind.noise_std, self.rungs.start.without(np.frombuffer(key, np.bool_))
        return np.asarray((part.filled(np.diag(noise)) / noise).T, dtype=np.float32)

    def search_of(self, rung: int, place: int, valid: NDArray[np.bool_] | None) -> tuple[Any, Any]:
        """Operator and memory of a patch, which goes on where the patch's last search ended.

        `valid` (L,) where not all taxels are.
        """
        data, last = self.data[rung][place], self.last[place]
        if last is not None and last is not data:
            data.start_from(last)
        self.last[place] = data
        if valid is None:
            return self.operators[rung], data
        return self._without(rung, valid.tobytes()), data

    def _prepared_without(self, rung: int, key: bytes) -> Operator:
        return self.operators[rung].without(np.frombuffer(key, np.bool_))  # type: ignore[no-any-return]

    def reset(self) -> None:
        """Forget the readings before."""
        for data in self.data:
            for each in data:
                each.reset()
        self.last = [None] * self.count


def _search(operator: Operator) -> Any:
    if not (hasattr(operator, "wide") or hasattr(operator, "problem")):
        raise InputError(
            f"the solver's {type(operator).__name__} has no test of idle patches, expected one "
            "such as that of NonNegative() or of Auto(), or a linear solver"
        )
    return operator
