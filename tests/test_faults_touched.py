"""Faults of skins that are touched: what is touched is not faulty, and what is faulty is found."""

import importlib
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

import skinfield as sf
from skinfield.errors import InputError
from skinfield.signal import CySkinCount, ICubByte, Verdict
from skinfield.signal.fault_evidence import chance_of_none
from skinfield.signal.faults import merged_faults

ROOT = Path(__file__).parents[1]
PATCH = sf.layouts.hexagon72()


def skin(seconds: float, rate: float, seed: int, clipped: bool) -> tuple[np.ndarray, np.ndarray]:
    """Counts of a skin that is touched in half of the time; taxels that ever are."""
    rng = np.random.default_rng(seed)
    readings = int(seconds * rate)
    scale = 40.0 * np.exp(0.6 * rng.standard_normal(len(PATCH)))
    counts = scale * rng.standard_t(3.0, (readings, len(PATCH)))
    ever = np.zeros(len(PATCH), np.bool_)
    length = int(0.5 * rate)
    for first in range(0, readings, 2 * length):
        middle = PATCH.plane[rng.integers(len(PATCH))]
        away = np.linalg.norm(PATCH.plane - middle, axis=1) / PATCH.pitch
        touch = 9000.0 * np.exp(-0.5 * np.square(away))
        counts[first : first + length] += touch * rng.uniform(0.6, 1.0)
        ever |= touch > 3000.0
    return np.rint(np.clip(counts, 0.0, None) if clipped else counts + 20000.0), ever


@pytest.mark.parametrize("clipped", [True, False])
@pytest.mark.parametrize("rate", [10.0, 50.0])
def test_what_is_touched_is_not_faulty(rate: float, clipped: bool) -> None:
    lost = touched = false = 0
    for seed in range(8):
        counts, ever = skin(5.0, rate, seed, clipped)
        usable = sf.find_faults(counts, PATCH, CySkinCount() if clipped else None).usable
        lost, touched = lost + int((ever & ~usable).sum()), touched + int(ever.sum())
        false += int((~usable).sum())
    assert touched > 100
    assert lost <= 1  # whose own noise is far beyond that of the others
    assert false <= 2  # of 576


@pytest.mark.parametrize("rate", [20.0, 50.0])
def test_taxels_far_noisier_than_all_others_are_found(rate: float) -> None:
    found = 0
    for seed in range(10):
        counts, _ = skin(5.0, rate, seed, clipped=False)
        rng = np.random.default_rng(seed)
        broken = int(rng.integers(len(PATCH)))
        counts[:, broken] += np.rint(6000.0 * rng.standard_normal(len(counts)))
        found += sf.find_faults(counts, PATCH).verdict[broken] == Verdict.NOISY
    assert found >= 9


def clipped(seed: int, below: float) -> np.ndarray:
    """Counts of a clipped board at rest, some taxels of which rest far below the clamp."""
    rng = np.random.default_rng(seed)
    rest = below * rng.standard_normal(len(PATCH))
    return np.rint(np.clip(rest + 40.0 * rng.standard_normal((60, len(PATCH))), 0.0, None))


def test_a_taxel_at_a_clipped_rest_is_dead_only_where_its_kind_rises_now_and_then() -> None:
    middle = int(np.argmin(np.abs(PATCH.plane).sum(axis=1)))
    counts = clipped(3, below=60.0)  # some are never above the clamp, as on real boards
    assert (np.ptp(counts, axis=0) == 0.0).sum() >= 3
    counts[:, middle] = 0.0
    assert sf.find_faults(counts, PATCH, CySkinCount()).usable.all()
    assert sf.find_faults(counts, None, CySkinCount()).usable.all()
    counts = clipped(3, below=0.0)
    counts[:, middle] = 0.0
    for patch in (PATCH, None):
        verdict = sf.find_faults(counts, patch).verdict
        assert np.flatnonzero(verdict == Verdict.DEAD).tolist() == [middle]


@pytest.fixture(scope="module")
def planted() -> Iterator[ModuleType]:
    """The benchmark's recordings, whose touches and noise the fault finder knows nothing of."""
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(ROOT / "benchmarks")
        yield importlib.import_module("fault_detection")


# What four draws give at least; the large table is the benchmark's.
LEAST_FOUND = {
    "dead": 1.0, "stuck at 0": 1.0, "stuck at a value": 1.0, "stuck at full scale": 1.0,
    "stops": 1.0, "absent": 1.0, "frozen board": 1.0, "deaf": 1.0, "warm": 0.75, "swapped": 0.75,
    "swapped boards": 0.75, "noisy x 10": 0.75,
}  # fmt: skip


@pytest.mark.parametrize("board", ["bytes", "clipped words"])
def test_planted_faults_are_found_within_seconds_of_touching(
    planted: ModuleType, board: str
) -> None:
    others = lost = 0.0
    for kind, least in LEAST_FOUND.items():
        faulty, found, *more, shown, _ = planted.found(kind, board, PATCH, 50.0, 4, 1)
        assert found / faulty >= least, kind
        assert 0.6 * faulty <= shown <= faulty, kind
        others, lost = others + more[0], lost + more[1]
    assert lost <= 0.002 * others


@pytest.mark.parametrize("board", ["bytes", "clipped words", "plain words"])
def test_healthy_taxels_are_kept_whatever_touches_them(planted: ModuleType, board: str) -> None:
    total = np.zeros(4)
    for scene in ("strokes", "hand", "idle"):
        for rate in (50.0, 10.0):
            total += planted.lost(scene, board, PATCH, rate, 4, 8)
    healthy, lost, pressed, pressed_lost = total
    assert pressed > 800
    assert pressed_lost <= 1
    assert lost <= 0.002 * healthy


def test_a_hand_that_holds_on_from_the_first_reading_loses_nothing(planted: ModuleType) -> None:
    patch = planted.large_skin()
    for board in ("clipped words", "bytes"):
        healthy, lost, pressed, pressed_lost = planted.lost("hand", board, patch, 20.0, 1, 9)
        assert healthy == 640
        assert pressed > 100
        assert pressed_lost == 0
        assert lost <= 1


def planted_in(
    planted: ModuleType, kind: str, seed: int | list[int], board: str = "clipped words"
) -> tuple[np.ndarray, np.ndarray]:
    """Counts with a fault, and its rows."""
    rng = np.random.default_rng(seed)
    counts, untouched, touched, _ = planted.recording(PATCH, planted.BOARDS[board], 50.0, rng)
    rows = planted.draw_rows(kind, PATCH, touched, rng)
    broken = planted.plant(kind, rows, counts, untouched, planted.BOARDS[board], rng)
    return planted.sent(broken, planted.BOARDS[board]), rows


def test_swapped_taxels_are_named_with_each_other(planted: ModuleType) -> None:
    named = 0
    for seed in ([1, 0], [1, 1], [1, 2], [1, 3]):
        counts, rows = planted_in(planted, "swapped", seed)
        faults = sf.find_faults(counts, PATCH)
        one, other = rows.reshape(-1)
        if faults.verdict[one] == Verdict.SWAPPED:
            assert f"taxel {other}," in faults.evidence[one]
            assert f"taxel {one}," in faults.evidence[other]
            assert faults.probability[one] > 0.9
            named += 1
    assert named >= 2


def test_swapped_boards_are_named_and_nothing_else_is(planted: ModuleType) -> None:
    counts, rows = planted_in(planted, "swapped boards", [1, 1], "bytes")
    one, other = PATCH.module[rows[:, 0]]
    faults = sf.find_faults(counts, PATCH)
    assert np.flatnonzero(~faults.usable).tolist() == sorted(rows.ravel().tolist())
    assert (faults.verdict[rows] == Verdict.SWAPPED).all()
    assert f"touches on board {other}," in faults.evidence[rows[0, 0]]
    assert f"touches on board {one}," in faults.evidence[rows[1, 0]]
    twice = merged_faults([faults, faults], [len(counts)] * 2)
    assert twice.verdict.tolist() == faults.verdict.tolist()
    whole = counts.copy()
    whole[:, rows.ravel()] = counts[:, rows[::-1].ravel()]
    healthy = sf.find_faults(whole, PATCH)
    assert healthy.usable.all()
    assert merged_faults([faults, healthy, healthy], [len(counts)] * 3).usable.all()


def test_a_board_that_is_not_seen_is_named_as_one(planted: ModuleType) -> None:
    counts, rows = planted_in(planted, "dead", 1, "bytes")
    board = np.flatnonzero(PATCH.module == 2)
    counts[:, board] = 200.0
    faults = sf.find_faults(counts, PATCH)
    assert (faults.verdict[board] == Verdict.FROZEN).all()
    assert "frozen at 200 since the start" in faults.evidence[board[0]]
    assert "board not seen, check wiring" in faults.evidence[board[0]]
    assert any("board 2" in said for said in faults.sentences)
    if rows[0] not in board:
        assert faults.verdict[rows[0]] == Verdict.DEAD
    counts[:125, board] = np.random.default_rng(0).normal(240.0, 3.0, (125, len(board))).round()
    faults = sf.find_faults(counts, PATCH)
    assert (faults.verdict[board] == Verdict.FROZEN).all()
    assert (np.abs(faults.since[board] - 125) <= 3).all()


def test_a_taxel_that_warmth_moves_and_no_touch_is_named_so(planted: ModuleType) -> None:
    kinds = []
    for seed in ([1, 0], [1, 1], [1, 2], [1, 3]):
        counts, rows = planted_in(planted, "warm", seed, "bytes")
        faults = sf.find_faults(counts, PATCH)
        kinds.append(faults.verdict[rows[0]])
        assert kinds[-1] != Verdict.TEMPERATURE or "drifts slowly" in faults.evidence[rows[0]]
    assert kinds.count(Verdict.TEMPERATURE) >= 2


def test_the_users_word_wins(planted: ModuleType) -> None:
    counts, rows = planted_in(planted, "stuck at a value", 2)
    row = int(rows[0])
    healthy = (row + 30) % len(PATCH)
    found = sf.find_faults(counts, PATCH)
    assert not found.usable[row]
    assert found.probability[row] > 0.9
    assert found.evidence[row]
    told = sf.find_faults(counts, PATCH, keep=[row], without=[healthy])
    assert told.usable[row]
    assert np.flatnonzero(told.verdict == Verdict.LEFT_OUT).tolist() == [healthy]
    assert not told.usable[healthy]
    assert any(said.startswith("kept as asked") for said in told.sentences)
    with pytest.raises(InputError, match="keep names taxels 72, expected rows of the patch, 0 to"):
        sf.find_faults(counts, PATCH, keep=[72])
    with pytest.raises(InputError, match="without names taxels -1"):
        sf.find_faults(counts, PATCH, without=[-1])
    with pytest.raises(InputError, match="both name taxels 3, expected"):
        found.chosen([3], [3])


def test_the_chance_of_no_change_is_that_of_taxels_of_many_shares() -> None:
    rng = np.random.default_rng(3)
    for a, b in ((2.0, 6.0), (30.0, 90.0)):
        number = rng.integers(40, 80, 4000)
        shown = rng.binomial(number, rng.beta(a, b, 4000))
        none = np.mean((1.0 - rng.beta(a, b, 400_000)) ** 12)
        assert chance_of_none(shown, number, 12) == pytest.approx(none, rel=0.12)
    same = rng.binomial(number, 0.2)  # all alike: what differs is counting
    assert chance_of_none(same, number, 30) == pytest.approx(0.8**30, rel=0.3)
    assert chance_of_none(same[:4], number[:4], 30) == 1.0


def test_counts_of_another_width_than_the_patch_are_refused() -> None:
    with pytest.raises(InputError, match="counts has 71 columns, expected 72 as patch"):
        sf.find_faults(np.zeros((20, 71)), PATCH)


@pytest.mark.parametrize("patch", [sf.layouts.hexagon72(), sf.layouts.icub_triangle()])
def test_a_skin_that_repeats_itself_as_a_whole_is_not_called_faulty(patch: sf.Patch) -> None:
    counts = np.full((110, len(patch)), 240.0)  # a quiet board that rounds to bytes
    assert sf.find_faults(counts, patch, ICubByte()).usable.all()
    counts[::7, 3] += 1.0
    assert sf.find_faults(counts, patch, ICubByte()).usable.all()
