"""Lost and doubled messages of iCub's boards, against what was done to them."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from icub_streams import (
    counted,
    decoded,
    delayed,
    filled,
    head,
    polled,
    regular,
    repeats,
    seeded,
    tail,
    wired,
)

from skinfield.signal import Blocks, Kind, counters
from skinfield.wire.icub import ICubDecoder

PERIODS = (20.0, 1.0)  # ms; the boards were told 50
TOLD = 0.05  # s


@pytest.mark.parametrize("period", PERIODS)
@pytest.mark.parametrize("triangles", [1, 2, 6, 16])
@pytest.mark.parametrize("rest", [True, False])
def test_nothing_is_amiss_with_what_is_in_order(period, triangles, rest):
    rows = regular(10 + 240 // triangles, triangles, period, rest)
    rng = seeded(triangles)
    for seen in (
        rows,
        polled(rows, 0.5),
        polled(rows, 7.0),
        polled(rows, 1e6),
        delayed(rows, rng, 0.01, 3 * period),
        delayed(rows, rng, 0.2, 0.5 * period),
    ):
        for told in (TOLD, 1e-3):
            assert set(decoded(seen, period=told)[1]) == {"RECEIVED", "READINGS", "BYTES"}


@pytest.mark.parametrize("rest", [True, False])
def test_boards_that_send_between_each_other_do_not_disturb(rest):
    rows = regular(200, 2, 1.0, rest) + regular(50, 16, 3.7, rest, board=2)
    rows.sort(key=lambda row: row[2])
    assert counted(polled(rows, 4.0), period=TOLD) == (0, 0)


def test_triangles_that_are_switched_off_or_on_do_not_disturb():
    many, few = regular(100, 16, 2.0, True), regular(200, 2, 2.0, True)
    for first, second in ((many, few), (few, many)):
        later = [(i, data, stamp + first[-1][2] + 2.0) for i, data, stamp in second]
        assert counted([*first, *later], period=TOLD) == (0, 0)


@given(st.sets(st.integers(0, 38)))
def test_a_part_that_is_missing_is_counted(missing):
    """Two of one kind in a row are one lost: what is missing in pairs cannot be seen."""
    rows = [row for k, row in enumerate(regular(20)) if k not in missing]
    rows += [(*head(77), 300.0), (*tail(77), 300.1), (*head(78), 310.0)]
    assert counted(rows, period=0.01) == (repeats(rows), 0)


@given(st.sets(st.integers(0, 39)), st.booleans())
def test_a_part_that_comes_again_at_once_is_a_copy(again, rest):
    rows = [
        row
        for k, row in enumerate(regular(20, rest=rest))
        for row in [row, (*row[:2], row[2] + 0.01)][: 1 + (k in again)]
    ]
    blocks, found = decoded(rows, period=0.01)
    assert found["DUPLICATED"] == len(again)
    assert found["LOST"] == 0
    assert found["READINGS"] == 40 == found["RECEIVED"] - len(again)
    assert sum(block.kind == Kind.BYTES for block in blocks) == 40


@pytest.mark.parametrize("period", PERIODS)
@pytest.mark.parametrize("triangles", [3, 6, 16])
@pytest.mark.parametrize("poll", [0.0, 7.0])
def test_losses_are_those_that_can_be_seen(period, triangles, poll):
    rows = regular(1500 // triangles, triangles, period, rest=True)
    for seed, lose in enumerate((0.01, 0.1)):
        seen, truth = wired(rows, seeded(seed), lose=lose)
        lost, duplicated = counted(polled(seen, poll) if poll else seen, period=TOLD)
        assert duplicated <= 0.3 * lose * lost  # most of a reading was lost at once
        owed = triangles + duplicated  # the last ones show only later
        assert repeats(seen) - owed <= lost <= repeats(seen)
        assert lost == pytest.approx(truth["lost"], rel=3 * lose + 0.1)


@pytest.mark.parametrize("period", PERIODS)
@pytest.mark.parametrize("triangles", [2, 6, 16])
@pytest.mark.parametrize("poll", [0.0, 7.0])
def test_copies_are_counted_exactly_in_heaps_too(period, triangles, poll):
    first, rows = regular(1, triangles, period), regular(1500 // triangles, triangles, period, True)
    seen, truth = wired(rows, seeded(1), duplicate=0.05)
    seen = first + [(i, d, s + period) for i, d, s in seen]
    found = counted(polled(seen, poll) if poll else seen, period=TOLD)
    assert found == (0, truth["duplicated"])


@pytest.mark.parametrize("triangles", [2, 6, 16])
@pytest.mark.parametrize("rest", [True, False])
def test_both_at_once_are_counted_nearly(triangles, rest):
    rows = regular(3000 // triangles, triangles, 1.0, rest)
    seen, truth = wired(rows, seeded(2), lose=0.02, duplicate=0.02)
    found = counted(polled(seen, 5.0), period=TOLD)
    np.testing.assert_allclose(found, [truth["lost"], truth["duplicated"]], rtol=0.1)


@pytest.mark.parametrize("period", PERIODS)
def test_of_a_single_triangle_time_tells(period):
    """Once its period is learned; messages in heaps are told apart by their data alone."""
    begin = regular(100, 1, period, rest=True)
    rows = [(i, d, s + 100 * period) for i, d, s in regular(1000, 1, period, rest=True)]
    seen, truth = wired(rows, seeded(3), lose=0.02)
    lost, duplicated = counted(begin + seen, period=TOLD)
    assert abs(lost - repeats(seen)) <= 3
    assert lost == pytest.approx(truth["lost"], rel=0.15)
    assert duplicated <= 2
    seen, truth = wired(rows, seeded(3), duplicate=0.02)
    assert counted(begin + seen, period=TOLD) == (0, truth["duplicated"])


@pytest.mark.parametrize("period", PERIODS)
@pytest.mark.parametrize("told", [1e-3, 0.05])
def test_the_period_that_a_board_keeps_is_learned(period, told):
    decoder = ICubDecoder([(0, 13), (0, 2)], period=told)
    assert decoder.periods == {}
    messages, count = filled(delayed(regular(200, 2, period), seeded(5), 0.02, period))
    decoder.decode(messages, count, Blocks(1 << 16), 0, counters())
    assert decoder.periods == {13: pytest.approx(period * 1e-3, rel=0.2)}
    decoder.reset()
    assert decoder.periods[13] == pytest.approx(period * 1e-3, rel=0.2)
