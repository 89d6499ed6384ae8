"""Interpreted kernels: they answer as compiled ones do, and a machine's first demo takes them."""

import gc
import json
import os
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from command_line import run
from matplotlib.text import Text

import skinfield as sf
from skinfield import compile_progress, compiled, plot
from skinfield.cli import demo
from skinfield.cli.main import interpret_first

ANSWERS = """
import json
from skinfield import compiled
compiled.interpret()
from test_interpreted import answers
from skinfield.solve.atoms.reading_kernel import answer_reading
assert answer_reading is answer_reading.py_func
print(json.dumps(answers()))
"""


def answers() -> dict[str, list[float]]:
    """What two touches are, by few contacts and by a field."""
    patch = sf.layouts.icub_triangle()
    x, y = (patch.plane - [[1e-3, 2e-3]]).T
    readings = 9e3 * np.exp(-(x**2 + y**2) / (2 * 3e-3**2))
    readings += np.random.default_rng(0).normal(scale=100.0, size=len(patch))
    found = {}
    for solver in (sf.Auto(), sf.NonNegative()):
        rec = sf.Reconstructor(
            patch, sf.Layer(), quantity=sf.BaseStress(), noise_std=100.0, solver=solver
        )
        estimate = rec(readings)
        contact = estimate.contacts[0]
        numbers = [*contact.position, contact.normal_force, contact.force_std, contact.area]
        found[type(solver).__name__] = [*map(float, numbers), float(estimate.pressure.sum())]
    return found


def printed_by(script: str, **environment: str) -> str:
    """What a process of its own prints."""
    path = os.pathsep.join([str(Path(__file__).parent), *filter(None, sys.path)])
    words, env = [sys.executable, "-c", script], os.environ | environment | {"PYTHONPATH": path}
    return subprocess.run(words, env=env, check=True, capture_output=True, text=True).stdout


def test_the_interpreter_answers_as_compiled_code_does() -> None:
    interpreted = json.loads(printed_by(ANSWERS))
    for solver, numbers in answers().items():
        np.testing.assert_allclose(interpreted[solver], numbers, rtol=1e-5, err_msg=solver)


def test_kernels_run_without_numbas_compiler() -> None:
    script = "from skinfield.solve.atoms.table import cubic, cubic_slopes; print(cubic(0.0))"
    assert printed_by(script, NUMBA_DISABLE_JIT="1").startswith("(0.1666")


@pytest.mark.parametrize(
    ("given", "is_there", "interpreted"),
    [
        ((), False, True),
        (("output", "force"), False, True),
        (("press",), False, False),
        (("model",), False, False),
        ((), True, False),
    ],
)
def test_only_the_first_usual_demo_is_interpreted(
    given: tuple[str, ...], is_there: bool, interpreted: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    called = []
    monkeypatch.setattr(compile_progress, "is_compiled", lambda name: is_there)
    monkeypatch.setattr(compiled, "interpret", lambda: called.append("interpreted"))
    monkeypatch.setattr(gc, "disable", lambda: called.append("keeps garbage"))
    interpret_first(given)
    assert called == ["interpreted", "keeps garbage"] * interpreted


@pytest.mark.parametrize("first", [True, False])
def test_time_of_the_interpreter_is_no_latency(
    first: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    figures = []
    words = ["demo", "--press", "0,6,2,6", "--solver", "gaussian", "-o", tmp_path / "d.png"]
    run(*words)  # compiles what is not there yet
    monkeypatch.setattr(demo, "_compile_in_background", lambda: None)
    monkeypatch.setattr(plot, "save", lambda figure, path: figures.append(figure))
    monkeypatch.setattr(compiled.MODE, "interpreted", first)
    said = run(*words, "--force")
    (figure,) = figures
    drawn = [text.get_text() for text in figure.findobj(Text)]
    assert (demo.COLD in said) == (demo.COLD in drawn) == first
    seconds = re.compile(r"latency: \d|cells of .*; [\d.]+ (s|ms|µs)$")
    assert any(map(seconds.search, drawn)) == bool(seconds.search(said)) == (not first)
