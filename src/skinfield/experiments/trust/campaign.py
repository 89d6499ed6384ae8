"""The campaign as parts that can run beside each other, and what they found, together."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from skinfield.campaign import run
from skinfield.errors import SkinfieldError
from skinfield.experiments.parts import tasks_of
from skinfield.experiments.scoring.rows import Row
from skinfield.experiments.section import Part
from skinfield.experiments.trust.attempts import idle_rows, rows_of_presses
from skinfield.experiments.trust.ball_bound import ball_profiles, bound_rows, radii
from skinfield.experiments.trust.plan import TrustPlan
from skinfield.experiments.trust.two_points import two_point_rows


@dataclass(frozen=True, eq=False)
class Found:
    """What came out.

    Attributes
    ----------
    rows : list of dict
        One per press, level and method, see `attempts.rows_of_case`.
    bound : list of dict
        Errors of estimates at the Cramér-Rao bound, see `ball_bound.bound_rows`.
    idle : list of dict
        Contacts in noise alone, one row per level and method.
    pairs : list of dict
        Two balls told apart, one row per distance, level and method.
    """

    rows: list[Row]
    bound: list[Row]
    idle: list[Row]
    pairs: list[Row]


def trust_parts(plan: TrustPlan) -> list[Part]:
    """Independent shares of the work."""
    presses = [
        Part(
            f"presses-{first:04d}",
            rows_of_presses,
            (plan, first, min(first + plan.share, plan.presses)),
        )
        for first in range(0, plan.presses, plan.share)
    ]
    return [
        *presses,
        *(
            Part(f"ball-{1e6 * radius:.0f}um", ball_profiles, (plan, radius))
            for radius in radii(plan)
        ),
        *(
            Part(f"idle-{level}".replace(" ", "-"), idle_rows, (plan, level))
            for level in plan.levels
            if level.noise > 0
        ),
        *(
            Part(f"two-{1e3 * distance:g}mm", two_point_rows, (plan, distance))
            for distance in plan.distances
        ),
    ]


def gathered(plan: TrustPlan, results: Sequence[dict[str, Any] | None]) -> Found:
    """Put the parts' results together; what failed is left out."""
    known = [result for result in results if result]

    def of(key: str) -> list[Row]:
        return [row for result in known for row in result.get(key, ())]

    tables = sorted((r for r in known if "profiles" in r), key=lambda part: float(part["radius"]))
    whole = bool(tables) and len(tables) == len(radii(plan))
    bound = bound_rows(plan, tables, of("balls")) if whole else []
    return Found(of("rows"), bound, of("idle"), of("pairs"))


def computed(
    plan: TrustPlan,
    folder: Path,
    workers: int = 1,
    progress: Callable[[int, int], None] = lambda done, of: None,
) -> Found:
    """Run all parts that `folder` does not hold yet.

    Raises
    ------
    SkinfieldError
        Where a part fails: with its last line, and the file that has the rest.
    """
    tasks, results = tasks_of(trust_parts(plan), "trust"), {}
    progress(0, len(tasks))
    for event in run(tasks, folder, workers=workers):
        outcome = event.outcome
        if outcome.failure:
            reason = outcome.failure.strip().splitlines()[-1]
            raise SkinfieldError(f"{outcome.name} fails: {reason} ({outcome.folder}.failed.txt)")
        results[outcome.name] = outcome.result
        progress(event.done, event.total)
    return gathered(plan, [results[task.name] for task in tasks])
