"""Judging a layout as a whole, the places where it is judged, and words for what is wrong."""

import numpy as np
import pytest

from skinfield.errors import InputError
from skinfield.layout import Patch
from skinfield.layout.generators import hexagon72, icub_triangle
from skinfield.mechanics import Layer
from skinfield.observation import BaseStress
from skinfield.resolution import (
    Places,
    SkinDesign,
    Touch,
    blind_spots,
    compare_thickness,
    detectable_force,
    judge,
)

LAYER = Layer(2e-3, 150e3, 0.5)


def stress_skin(patch: Patch) -> SkinDesign:
    return SkinDesign(patch=patch, layer=LAYER, quantity=BaseStress(), noise_std=400.0)


def test_judging_says_what_it_found() -> None:
    design = stress_skin(icub_triangle())
    told: list[str] = []
    found = judge(design, Touch.small(LAYER), Places.over(design.patch, 1e-3), on_map=told.append,
                  two_point_places=Places.over(design.patch, 5e-3), ways=4)  # fmt: skip
    assert len(told) == 4
    rows = {row.name: row for row in found.rows()}
    assert all(row.median <= row.p90 <= row.p95 <= row.worst for row in found.rows()[1:])
    place = rows["place deviation, size unknown"]
    assert place.median == pytest.approx(np.median(found.accuracy.place_std) * 1e3, rel=0.05)
    assert "0.5 N" in found.verdict()
    assert "blind" in found.verdict()
    assert (found.accuracy.place_std >= found.accuracy.place_std_known_size * (1 - 1e-9)).all()
    assert (found.detectable.unknown_place > found.detectable.known_place).all()


def test_a_skin_that_feels_nothing_is_said_to() -> None:
    design = SkinDesign(patch=icub_triangle(), layer=LAYER, quantity=BaseStress(), noise_std=1e7)
    coarse = Places.over(design.patch, 2e-3)
    found = judge(design, Touch(0.5, 1e-3), coarse, two_point_places=coarse, ways=4)
    assert "is found nowhere; half of the patch places it no better than a guess" in found.verdict()
    assert "tells no two apart" in found.verdict()


def test_comparison_keeps_the_touch_and_sorts() -> None:
    design = stress_skin(icub_triangle())
    found = compare_thickness(design, Touch(0.5, 1e-3), [4e-3, 2e-3])
    assert found.thickness.tolist() == [2e-3, 4e-3]
    assert {judgement.touch for judgement in found.judgements} == {Touch(0.5, 1e-3)}
    name = "place deviation, size unknown"
    thin, thick = found.rows(name)
    assert thick.median < thin.median
    assert found.best(name) == 4e-3
    with pytest.raises(InputError, match="expected one of"):
        found.rows("beauty")
    with pytest.raises(InputError, match="two or more"):
        compare_thickness(design, Touch(0.5, 1e-3), [2e-3])


def test_bad_input_is_named() -> None:
    with pytest.raises(InputError, match="noise_std"):
        SkinDesign(patch=hexagon72(), layer=LAYER, noise_std=-1.0)
    with pytest.raises(InputError, match="noise_std has shape"):
        SkinDesign(patch=hexagon72(), layer=LAYER, noise_std=np.ones(3))
    with pytest.raises(InputError, match="radius is"):
        blind_spots(stress_skin(hexagon72()), Touch(0.5, 0.1e-3))
    with pytest.raises(InputError, match="force is"):
        Touch(-1.0, 1e-3)
    with pytest.raises(InputError, match="pitch is"):
        Places.over(hexagon72(), -1.0)
    with pytest.raises(InputError, match=r"pitch is 1e-06 m, which makes .* take 9.[0-9]e-05 m or"):
        Places.over(hexagon72(), 1e-6)
    with pytest.raises(InputError, match="false_alarm_rate"):
        detectable_force(stress_skin(hexagon72()), Touch(0.5, 1e-3), false_alarm_rate=0.5)
    with pytest.raises(InputError, match="threshold"):
        blind_spots(stress_skin(hexagon72()), Touch(0.5, 1e-3), threshold=2.0)


def test_places_cover_the_patch_and_its_pads() -> None:
    patch = Patch(np.zeros((1, 2)))
    alone = Places.over(patch)
    assert alone.area == pytest.approx(np.pi * 2e-3**2, rel=0.05)
    places = Places.over(hexagon72(), 1e-3)
    values = np.arange(len(places), dtype=np.float64)
    picture = places.picture(values)
    np.testing.assert_array_equal(picture[places.inside], values)
    assert np.isnan(picture[~places.inside]).all()
    halves = [places.plane[:, 0] < -5e-3, places.plane[:, 0] > 5e-3]
    assert [len(list(places.parts(m))) for m in (halves[0], halves[0] | halves[1])] == [1, 2]
