"""A cycle done again, by what its script says in place of the clock."""

from collections.abc import Sequence

from numpy.typing import ArrayLike

from skinfield.engine.clockwork import Clockwork
from skinfield.engine.linear_stages import answer_linearly, refine_one, with_more_to_gain
from skinfield.engine.script import SEARCH, checked_script
from skinfield.engine.search_stages import (
    search_again,
    start_linearly,
    take_in,
    test_all,
)
from skinfield.engine.state import MASKED, TEST
from skinfield.errors import Ints

Row = Sequence[int]


def told_by(script: ArrayLike, work: Clockwork) -> list[list[int]]:
    """Rows of a script, or InputError if a cycle of such an engine cannot have left it."""
    return checked_script(script, len(work.places), work.rungs, work.linear, work.script.most)


def done_again(work: Clockwork, script: Sequence[Row]) -> Ints:
    """Answer the readings that were taken in, as a cycle with this script did.

    Returns the patches with a contact, as `spend` and `refine_linearly` do.
    """
    return _answered_again(work, script) if work.linear else _searched_again(work, script)


def _answered_again(work: Clockwork, script: Sequence[Row]) -> Ints:
    answer_linearly(work, script[0][2])
    hot = with_more_to_gain(work, script[0][2])
    for _, patch, rung, _, _ in script[1:]:
        refine_one(work, patch, rung)
    return hot


def _searched_again(work: Clockwork, script: Sequence[Row]) -> Ints:
    hot = work.hot[:0]
    for at, (entry, patch, rung, ending, settled) in enumerate(script):
        if entry == TEST:
            hot = test_all(work, rung, _masked_after(script, at))
        elif entry == SEARCH:
            take_in(work, [search_again(work, patch, rung, ending, settled > 0)], hot)
    start_linearly(work)
    return hot


def _masked_after(script: Sequence[Row], at: int) -> dict[int, int]:
    """Rungs of masked patches that follow an idle test."""
    found = {}
    for entry, patch, rung, _, _ in script[at + 1 :]:
        if entry != MASKED:
            break
        found[patch] = rung
    return found
