"""The same layout under elastomers of several thicknesses."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from skinfield.errors import Floats, InputError, as_floats, check_positive, check_shape
from skinfield.resolution.design import SkinDesign, Touch
from skinfield.resolution.judgement import Judgement, Row, Terms, judge
from skinfield.resolution.two_points import few_places

FEW = 120  # places of the two touches, per thickness


@dataclass(frozen=True, eq=False)
class ThicknessComparison:
    """Judgements of one layout and touch, by thickness.

    Attributes
    ----------
    thickness : (T,) array, m
    judgements : tuple of T Judgement
    """

    thickness: Floats
    judgements: tuple[Judgement, ...]

    def rows(self, name: str) -> tuple[Row, ...]:
        """One map in numbers, by thickness.

        Raises
        ------
        InputError
            When no map has that name; the message lists them.
        """
        names = [row.name for row in self.judgements[0].rows()]
        if name not in names:
            raise InputError(f"name is {name!r}, expected one of {', '.join(names)}")
        at = names.index(name)
        return tuple(judgement.rows()[at] for judgement in self.judgements)

    def best(self, name: str) -> float:
        """Thickness in m whose median of a map is smallest."""
        return float(self.thickness[np.argmin([row.median for row in self.rows(name)])])


def compare_thickness(
    design: SkinDesign,
    touch: Touch,
    thicknesses: Sequence[float],
    *,
    terms: Terms | None = None,
    on_thickness: Callable[[float], None] | None = None,
) -> ThicknessComparison:
    """Judge a layout under several thicknesses; the touch stays as it is.

    Parameters
    ----------
    design : SkinDesign
        Whose thickness does not count.
    touch : Touch
    thicknesses : sequence of float, m
    terms : Terms, optional
    on_thickness : function of float, optional
        Called with each thickness in m before it is judged.
    """
    values = np.sort(as_floats("thicknesses", thicknesses))
    check_shape("thicknesses", values, (None,), "in metres")
    if len(values) < 2:
        raise InputError(f"thicknesses is {values.tolist()}, expected two or more to compare")
    for value in values:
        check_positive("thicknesses", float(value), "in metres")
        touch.check_on(replace(design.layer, thickness=float(value)))
    few = few_places(design, FEW)
    judgements = []
    for value in values:
        if on_thickness is not None:
            on_thickness(float(value))
        thick = replace(design, layer=replace(design.layer, thickness=float(value)))
        judgements.append(judge(thick, touch, two_point_places=few, terms=terms))
    return ThicknessComparison(values, tuple(judgements))
