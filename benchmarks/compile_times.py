"""Times of compilation, function by function: writes src/skinfield/compile_times.json anew.

  python benchmarks/compile_times.py

It takes some minutes of one core. Each use is run once with an empty cache, on one processor, so
that all is compiled in one process. Times are those of the thread that compiles: other programs
that run meanwhile hardly matter.
"""

import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path

OUT = Path(__file__).parents[1] / "src" / "skinfield" / "compile_times.json"
SHORT = 0.15  # s: shorter functions are told together
LISTENER = """
import atexit, json, os, time
from numba.core.event import Listener, register

class Times(Listener):
    def __init__(self):
        self.stack, self.seconds = [], {}
    def on_start(self, event):
        function = event.data["dispatcher"].py_func
        name = f"{function.__module__}.{function.__qualname__}"
        self.stack.append([name, time.thread_time(), 0.0])
    def on_end(self, event):
        name, began, within = self.stack.pop()
        took = time.thread_time() - began
        its = self.seconds.setdefault(self.stack[0][0] if self.stack else name, {})
        its[name] = its.get(name, 0.0) + took - within
        if self.stack:
            self.stack[-1][2] += took

times = Times()
register("numba:compile", times)

def write():
    with open(os.path.join(os.environ["COMPILE_TIMES"], str(os.getpid())), "w") as file:
        json.dump(times.seconds, file)

atexit.register(write)
leave = os._exit
os._exit = lambda code=0: (write(), leave(code))
"""
COMMANDS = {
    "reconstruct": "demo --press 13,-12,3,10 --press -16,8,2,6 -o {}/demo.png",  # not interpreted
    "run": "warmup",
}
INTERPRETED = """
from skinfield.compiled import interpret
interpret()
from skinfield import Layer, Reconstructor, layouts
from skinfield.simulate import Sphere, press
patch, layer = layouts.icub_triangle(), Layer()
pressed = press(layer, [Sphere(radius=6e-3, force=1.0)], extent=40e-3, cell=0.5e-3)
Reconstructor(patch, layer)(pressed.readings(patch.plane, patch.pad_diameter, "capacitance"))
"""


def times_of(*words: str) -> dict[str, dict[str, float]]:
    """Seconds by outermost function and function, of all processes of a command of Python."""
    found: dict[str, dict[str, float]] = {}
    with tempfile.TemporaryDirectory() as folder:
        for name in ("site", "cache", "times"):
            Path(folder, name).mkdir()
        Path(folder, "site", "sitecustomize.py").write_text(LISTENER)
        path = os.pathsep.join([f"{folder}/site", str(OUT.parents[1])])
        own = {"NUMBA_CACHE_DIR": f"{folder}/cache", "COMPILE_TIMES": f"{folder}/times"}
        os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})
        command = [sys.executable, *(word.replace("{}", folder) for word in words)]
        subprocess.run(command, env=os.environ | own | {"PYTHONPATH": path}, check=True)
        for file in sorted(Path(folder, "times").iterdir(), key=lambda each: each.stat().st_mtime):
            for outermost, seconds in json.loads(file.read_text()).items():
                found.setdefault(outermost, seconds)
    return {name: its for name, its in found.items() if name.startswith("skinfield.")}


def told_short(seconds: dict[str, float]) -> dict[str, float]:
    """Functions that take long, and all others together."""
    long = {name: round(its, 2) for name, its in seconds.items() if its >= SHORT}
    return {**long, "": round(sum(seconds.values()) - sum(long.values()), 2)}


def main() -> None:
    """Measure, and write."""
    by_use = {use: times_of("-m", "skinfield", *its.split()) for use, its in COMMANDS.items()}
    by_use["heavy"] = times_of("-c", INTERPRETED)
    seconds = {name: told_short(its) for each in by_use.values() for name, its in each.items()}
    seconds = {name: its for name, its in seconds.items() if sum(its.values()) >= 0.05}
    uses = {use: [name for name in each if name in seconds] for use, each in by_use.items()}
    fit = next(i for i, name in enumerate(uses["run"]) if ".solve.atoms." in name)
    uses["linear"] = uses["run"][:fit]
    OUT.write_text(json.dumps({"seconds": seconds, "uses": uses}, indent=1) + "\n")


if __name__ == "__main__":
    main()
