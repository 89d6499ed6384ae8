"""Feed a parser of skinfield with inputs that grow towards new branches, until one breaks it.

  python fuzz/run.py                               the targets there are
  python fuzz/run.py fuzz_packet --seconds 600     fuzz one of them
  python fuzz/run.py fuzz_packet --again FILE      run one input again, with its traceback

A target is a file fuzz/fuzz_NAME.py with a function `one_input(data: bytes) -> None`, which raises
nothing unless the parser makes a mistake. SEEDS, a list of good inputs to begin with, may stand
there too, and INTERPRETED = True where its kernels may run as plain Python.

Atheris finds the inputs: `python -m pip install atheris`. Without it, --plain tries random ones,
which sees less. Kernels run compiled, with Numba's check of indices, and as plain Python where the
target says so: then their branches are seen too. That needs kernels that turn what they read from
an array into an int before they add or shift, as NumPy's small integers overflow. Inputs that
reached something new stay in --corpus, outside the project, and the next run begins with them. The
exit status is 1 if something was found, else 0.
"""

from __future__ import annotations

import argparse
import importlib
import importlib.util
import os
import random
import re
import subprocess
import sys
import time
import traceback
from collections.abc import Callable
from pathlib import Path

HERE = Path(__file__).resolve().parent
SOURCES = HERE.parent / "src"
CORPUS = Path(os.environ.get("XDG_CACHE_HOME", Path.home() / ".cache")) / "skinfield-fuzz"
LONGEST = 4096  # bytes of an input
SLOW = 20  # seconds for one input, after which it counts as endless
MOST_MB = 3072
GRACE = 300  # seconds for starting and compiling, beyond those asked for
NO_ATHERIS = (
    "run.py: atheris is not installed, expected it: python -m pip install atheris. "
    "Or --plain for random inputs, which see less."
)

OneInput = Callable[[bytes], None]


def main() -> int:
    """Run what the command line asks for; return the exit status."""
    asked = arguments()
    names = sorted(file.stem for file in HERE.glob("fuzz_*.py"))
    if asked.target is None:
        say("\n".join(names))
        return 0
    if asked.target not in names:
        say(f"run.py: {asked.target!r} is no target, expected one of {', '.join(names)}")
        return 2
    text = (HERE / f"{asked.target}.py").read_text()
    plain = re.search(r"^INTERPRETED = True$", text, re.MULTILINE)
    asked.kernels = "interpreted" if plain else "compiled"
    if asked.child:
        return child(asked)
    if asked.again:
        return again(asked)
    if not asked.plain and importlib.util.find_spec("atheris") is None:
        say(NO_ATHERIS)
        return 2
    return parent(asked)


def arguments() -> argparse.Namespace:
    """The command line, read."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("target", nargs="?", help="name of a file beside this one, without .py")
    parser.add_argument("--seconds", type=int, default=60, help="how long (default 60)")
    parser.add_argument("--corpus", type=Path, help=f"folder of inputs (default {CORPUS}/TARGET)")
    parser.add_argument("--plain", action="store_true", help="random inputs, without atheris")
    parser.add_argument("--seed", type=int, default=0, help="of the random numbers (0: the clock)")
    parser.add_argument("--again", type=Path, metavar="FILE", help="run this one input")
    parser.add_argument("--child", action="store_true", help=argparse.SUPPRESS)
    asked = parser.parse_args()
    asked.corpus = (asked.corpus or CORPUS / str(asked.target)).absolute()
    return asked


def parent(asked: argparse.Namespace) -> int:
    """Fuzz in a process of its own, as a crash must not take the report with it."""
    found = asked.corpus / "found"
    found.mkdir(parents=True, exist_ok=True)
    before = set(found.iterdir())
    log = asked.corpus / "log.txt"
    say(f"{asked.target}: {asked.seconds} s, kernels {asked.kernels}, inputs in {asked.corpus}")
    began = time.monotonic()
    with log.open("wb") as stream:
        status = subprocess.run(
            [sys.executable, __file__, *sys.argv[1:], "--child"],
            stdout=stream, stderr=subprocess.STDOUT, env=environment(asked), check=False,
            timeout=asked.seconds + GRACE + SLOW,
        ).returncode  # fmt: skip
    text = log.read_text(errors="replace")
    new = sorted(set(found.iterdir()) - before)
    runs = re.findall(r"stat::number_of_executed_units: (\d+)", text)
    if status == 0 and not new and runs:
        took = time.monotonic() - began
        say(f"{asked.target}: {runs[-1]} executions in {took:.0f} s, nothing found")
        return 0
    say("\n".join(text.splitlines()[-40:]))
    say(f"{asked.target}: {runs[-1] if runs else 'unknown'} executions, exit status {status}")
    for file in new:
        say(f"found: {file}\n  python fuzz/run.py {asked.target} --again {file}")
    return 1


def environment(asked: argparse.Namespace) -> dict[str, str]:
    """That of the child: how Numba works is settled before it is imported."""
    values = {**os.environ, "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
    if asked.kernels == "interpreted":
        return {**values, "NUMBA_DISABLE_JIT": "1"}
    cache = str(asked.corpus / "compiled")  # code with checks must not get into the usual cache
    return {**values, "NUMBA_BOUNDSCHECK": "1", "NUMBA_CACHE_DIR": cache}


def child(asked: argparse.Namespace) -> int:
    """Load the target and fuzz it; does not return with atheris."""
    inputs = asked.corpus / "inputs"
    inputs.mkdir(exist_ok=True)
    if asked.plain:
        return fuzz_plainly(load(asked.target, inputs), inputs, asked)
    import atheris

    options = [
        sys.argv[0], str(inputs), f"-max_total_time={asked.seconds}", f"-timeout={SLOW}",
        f"-max_len={LONGEST}", f"-rss_limit_mb={MOST_MB}", f"-seed={asked.seed}",
        f"-artifact_prefix={asked.corpus / 'found'}/", "-print_final_stats=1",
    ]  # fmt: skip
    exclude = kernel_modules() if asked.kernels == "compiled" else []
    # The hook stays to the end: kernels are imported when they are first called.
    with atheris.instrument_imports(include=["skinfield", asked.target], exclude=exclude):
        one_input = load(asked.target, inputs)
        one_input(b"")
        atheris.Setup(options, one_input)
        atheris.Fuzz()
    return 0


def kernel_modules() -> list[str]:
    """Modules with compiled functions: Numba cannot read them once they are instrumented."""
    kernels = re.compile(r"^\s*from (numba|skinfield\.compiled) import", re.MULTILINE)
    files = (file for file in SOURCES.rglob("*.py") if kernels.search(file.read_text()))
    return [".".join(file.relative_to(SOURCES).with_suffix("").parts) for file in files]


def load(target: str, inputs: Path) -> OneInput:
    """Function of a target; its seeds become the first inputs."""
    sys.path.insert(0, str(HERE))
    module = importlib.import_module(target)
    for number, seed in enumerate(getattr(module, "SEEDS", [])):
        (inputs / f"seed-{number}").write_bytes(seed)
    one_input: OneInput = module.one_input
    return one_input


def fuzz_plainly(one_input: OneInput, inputs: Path, asked: argparse.Namespace) -> int:
    """Random inputs and changes of known ones, until the time is over or one breaks it."""
    random_numbers = random.Random(asked.seed or time.time_ns())
    known = [file.read_bytes() for file in sorted(inputs.iterdir())] or [b""]
    last, count = asked.corpus / "found" / "crash-plain", 0
    until = time.monotonic() + asked.seconds
    while time.monotonic() < until:
        data = changed(random_numbers, known)
        last.write_bytes(data)  # stays if the process dies with it
        try:
            one_input(data)
        except BaseException:
            say(traceback.format_exc())
            return 1
        count += 1
    last.unlink(missing_ok=True)
    say(f"stat::number_of_executed_units: {count}")
    return 0


def changed(numbers: random.Random, known: list[bytes]) -> bytes:
    """A known input with some bytes changed, cut, doubled or put in; or nothing but chance."""
    if numbers.random() < 0.2:
        return numbers.randbytes(numbers.randrange(200))
    data = bytearray(numbers.choice(known))
    for _ in range(numbers.randrange(1, 6)):
        at, size = numbers.randrange(len(data) + 1), numbers.randrange(1, 12)
        match numbers.randrange(4):
            case 0:
                data[at : at + size] = numbers.randbytes(size)
            case 1:
                del data[at : at + size]
            case 2:
                data[at:at] = data[at : at + size]
            case 3:
                data[at:at] = numbers.randbytes(size)
    return bytes(data[:LONGEST])


def again(asked: argparse.Namespace) -> int:
    """Run one input as it is; its exception, if any, is Python's own."""
    for name, value in environment(asked).items():
        os.environ[name] = value
    inputs = asked.corpus / "inputs"
    inputs.mkdir(parents=True, exist_ok=True)
    load(asked.target, inputs)(asked.again.read_bytes())
    say(f"{asked.again}: nothing happens")
    return 0


def say(text: str) -> None:
    """Write a line at once."""
    sys.stdout.write(f"{text}\n")
    sys.stdout.flush()


if __name__ == "__main__":
    sys.exit(main())
