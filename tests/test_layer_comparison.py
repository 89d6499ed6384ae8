"""Layers compared by touches: the one that presses were solved on is named, with its odds."""

import json
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from command_line import refused, run

import skinfield as sf
from skinfield.calibrate import LayerComparison, LayerModel, compare_layers, layer_comparison
from skinfield.calibrate.layer_comparison import usual_layers
from skinfield.errors import InputError
from skinfield.files import save_recording
from skinfield.skin.reading import Recording

PATCH, LAYER, NOISE = sf.layouts.hexagon72(), sf.Layer(), 1e-3
SOFTER, COVERED = usual_layers(LAYER, sf.BondedLayer())[0::2][:2]
STATED = LayerModel("what is stated", LAYER)
WORLDS = {"stated": STATED, "softer": SOFTER, "covered": COVERED}


@cache
def touches(world: str) -> np.ndarray:
    """Readings (T, L) of two balls and a flat end, each at three places, by the press solver."""
    layer, mechanics, rng = WORLDS[world].layer, WORLDS[world].mechanics, np.random.default_rng(2)
    bodies = [
        sf.simulate.Sphere(radius=5e-3, force=1.0),
        sf.simulate.Sphere(radius=10e-3, force=2.0),
        sf.simulate.Cylinder(radius=3e-3, force=1.5),
    ]
    middle, half = PATCH.plane.mean(axis=0), 0.3 * np.ptp(PATCH.plane, axis=0)
    made = []
    for body in bodies:
        true = sf.simulate.press(layer, [body], extent=28e-3, cell=0.4e-3, mechanics=mechanics)
        places = rng.uniform(middle - half, middle + half, (3, 2))
        made += [true.capacitance(PATCH.plane - at, PATCH.pad_diameter) for at in places]
    return np.array(made) + rng.normal(scale=NOISE, size=(9, len(PATCH)))


@cache
def compared(world: str) -> LayerComparison:
    return compare_layers(
        PATCH, touches(world), layer=LAYER, others=(SOFTER, COVERED), noise_std=NOISE
    )


@pytest.mark.parametrize("world", WORLDS)
def test_touches_tell_the_layer_that_they_were_solved_on(world: str) -> None:
    made = compared(world)
    assert [model.name for model in made.likely] == [WORLDS[world].name]
    assert made.probability.sum() == pytest.approx(1.0)
    assert made.fits == (world == "stated")
    assert ("like an inextensible cover" in made.verdict) == (world == "covered")
    at = list(WORLDS).index(world)
    assert made.model_error[at] == made.model_error.min()
    assert world == "stated" or made.force_ratio[at] > 1.2  # the wrong layer hides force
    assert made.force_ratio[0] == 1.0


def made_of(evidence: list[list[float]], place: list[int], error: float = 0.01) -> LayerComparison:
    models = (STATED, SOFTER, COVERED)
    return LayerComparison(
        models, np.array(evidence), np.array(place), np.full(3, error), np.array([1.0, 1.5, np.nan])
    )


def test_probability_is_that_of_bayes_with_a_bound_and_one_vote_of_a_place() -> None:
    told = [[-1.0, 0.0, -90.0]] * 4
    apart, together = made_of(told, [1, 2, 3, 4]), made_of(told, [5, 5, 5, 5])
    # odds by hand: stated 0 and others -2 before, -2.5 a place at most
    for made, places in ((apart, 4.0), (together, 1.0)):
        odds = np.exp([-1.0 * places, -2.0, -2.0 - 2.5 * places])
        np.testing.assert_allclose(made.probability, odds / odds.sum())
    assert apart.probability[1] > 0.85
    assert together.fits


def test_what_reads_alike_is_named_together() -> None:
    alike = made_of([[-9.0, -0.1, 0.0]] * 6, list(range(6)))
    assert set(alike.likely) == {SOFTER, COVERED}
    assert f"{COVERED.name} or {SOFTER.name}, which read alike" in alike.verdict
    assert "above 0.99 over 6 touches" in alike.verdict
    open_still = made_of([[-0.5, 0.0, -9.0]] * 6, list(range(6)), error=0.2)
    assert "do not tell" in open_still.verdict
    assert "20% off" in open_still.verdict


def test_usual_layers_differ_from_what_is_stated_in_one_thing_each() -> None:
    models = usual_layers(replace(LAYER, poisson_ratio=0.44), sf.BondedLayer(True))
    assert [model.layer.poisson_ratio for model in models] == [0.5, 0.4, 0.44, 0.44, 0.44]
    covers = [model.mechanics.inextensible_cover for model in models]
    assert covers == [True, True, False, True, True]
    thickness = np.array([model.layer.thickness for model in models]) / LAYER.thickness
    np.testing.assert_allclose(thickness, [1.0, 1.0, 1.0, 0.8, 1.25])
    assert len({model.name for model in models}) == 5


def test_a_comparison_has_a_picture_and_a_table() -> None:
    made = compared("softer")
    axes = made.plot()
    assert [bar.get_width() for bar in axes.patches] == pytest.approx(made.probability)
    assert axes.get_yticklabels()[0].get_text() == "what is stated"
    assert axes.get_xlabel() == "probability"
    page = made._repr_html_()
    assert "<img" in page
    assert SOFTER.name.replace("'", "&#x27;") in page
    assert made.verdict in repr(made)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"others": ()}, "others is empty"),
        ({"others": [LAYER]}, "others is .*LayerModel"),
        ({"mechanics": sf.HalfSpace()}, "mechanics .*BondedLayer"),
        ({"quantity": LAYER}, "quantity .*Capacitance"),
    ],
)
def test_what_cannot_be_compared_is_refused(arguments: dict, message: str) -> None:
    with pytest.raises(InputError, match=message):
        compare_layers(PATCH, touches("stated"), **{"noise_std": NOISE} | arguments)


def test_too_few_touches_are_refused() -> None:
    with pytest.raises(InputError, match=r"hold [12] touches .* expected 3 or more, better 20"):
        compare_layers(PATCH, touches("stated")[:2], noise_std=NOISE)


def test_the_command_names_the_layer_of_a_recording(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(layer_comparison, "usual_layers", lambda *_: (SOFTER, COVERED))
    rng, rows = np.random.default_rng(6), np.repeat(touches("softer"), 6, axis=0)
    rest = NOISE * rng.standard_normal((60, len(PATCH)))
    counts = 20_000.0 + 20_000.0 * np.vstack([rest, rows + NOISE * rng.standard_normal(rows.shape)])
    skin = tmp_path / "touches.csv"
    save_recording(Recording(np.arange(len(counts)) * 20_000_000, np.rint(counts)), skin)
    known = ("--skin", "hexagon72", "--gain", "20000", "--poisson", "0.5")
    layer = ("--thickness-mm", "2", "--modulus-kpa", "150")
    said = run("calibrate", "layer", skin, *known, *layer, "--json", "--report", tmp_path / "page")
    result = json.loads(said.splitlines()[0])
    assert result["verdict"].startswith("the skin does not read as stated, but like")
    (best,) = [row for row in result["layers"] if row["probability"] > 0.95]
    assert best["poisson"] == SOFTER.layer.poisson_ratio
    assert not result["fits"]
    assert (tmp_path / "page" / "probability-of-each-layer.png").stat().st_size > 10_000
    assert "RECORDING is missing" in refused("calibrate", "layer", *known)
    assert "half-space" in refused("calibrate", "layer", skin, *known, "--mechanics", "half-space")
