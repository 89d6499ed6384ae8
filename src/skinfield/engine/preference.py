"""What an engine shall look at first, and how closely at the rest."""

from typing import TYPE_CHECKING

from skinfield.errors import check_count

if TYPE_CHECKING:
    from skinfield.engine.engine import Engine


def prefer(engine: "Engine", finest: int | None = None, first: int | None = None) -> None:
    """Say how the next cycles spend their time; a script holds what that comes to.

    Idle tests are made on every rung all the same: what touches the skin does not go unnoticed.

    Parameters
    ----------
    engine : Engine
    finest : int, optional
        Rung beyond which no patch is answered, counted from the coarsest. Default the finest.
    first : int, optional
        Patch, in the skin's order, that is served before all others, and on any rung.

    Raises
    ------
    InputError
        If there is no such rung or patch.
    """
    work = engine._work
    top = work.rungs - 1
    if finest is not None:
        check_count("finest", finest, 0, top, "rung, counted from the coarsest")
        top = finest
    row = -1
    if first is not None:
        check_count("first", first, 0, len(engine.names) - 1, "patch, in the skin's order")
        row = engine.results.row_of(first)
    work.prefer(top, row)
