"""Imports go down the floors, never up or sideways: the architecture, as a test."""

import ast
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

import skinfield

FLOORS = [  # top floor first; rooms of one floor never import each other
    {"cli"},
    {"viewer", "bridges", "config"},
    {"lab", "live", "virtual"},
    {"sources", "sinks", "plot", "testing", "campaign"},  # the edge
    {"engine"},
    {"pipeline", "resolution", "detection"},
    {"inverse", "simulate", "calibrate", "contacts", "protocols"},
    {"observation", "conditioning", "acquisition"},
    {"mechanics", "fields", "settings"},
    {"layout", "reading", "ring", "realtime"},
    {"errors", "compiled"},
]
FLOOR = {room: floor for floor, rooms in enumerate(FLOORS) for room in rooms}
CORE = {"numpy", "scipy", "numba"}
ELSEWHERE = {  # third-party packages outside the core, and the rooms that may import them
    "llvmlite": {"compiled", "inverse"},  # the half of Numba that writes machine code
    "rich": {"cli"},
    "cyclopts": {"cli"},
    "msgspec": {"settings"},
    "tomli_w": {"settings", "config"},
    "threadpoolctl": {"cli"},
    "matplotlib": {"plot", "lab"},
    "mpl_toolkits": {"plot"},
    "pyarrow": {"fields", "sinks", "sources"},
    "zarr": {"sinks", "sources"},
    "xarray": {"fields", "sources"},  # the types that to_xarray and open_results return
    "dask": {"sources"},
    "distributed": {"cli"},
    "skfem": {"lab"},
    "trimesh": {"sources"},
    "PIL": {"sources"},
    "can": {"sources"},
    "serial": {"sources"},
    "mcap": {"sinks", "sources"},
    "zstandard": {"sinks", "sources"},
    "lz4": {"sinks", "sources"},  # comes with mcap
    "h5py": {"sinks"},
    "rosbags": {"sinks", "bridges"},
    "websockets": {"viewer"},
    "xxhash": {"bridges"},
    "zenoh": {"bridges"},
    "rclpy": {"bridges"},  # comes with ROS 2, never from PyPI
    "jinja2": {"lab"},
    "pytest": {"testing"},  # the contracts are tests
}
ROOMS = {"experiments": "lab", "figures": "lab"}  # what is part of a room under another name
ROOT = Path(skinfield.__file__).parent
FILES = [file for file in ROOT.rglob("*.py") if file != ROOT / "__init__.py"]


def room_of(file: Path) -> str:
    room = file.relative_to(ROOT).parts[0].removesuffix(".py")
    return ROOMS.get(room, room)


def imports_of(file: Path) -> Iterator[tuple[int, str]]:
    for node in ast.walk(ast.parse(file.read_text())):  # nested imports too
        if isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{file}:{node.lineno} imports relatively"
            module = node.module or ""
            names = [f"skinfield.{a.name}" for a in node.names] if module == "skinfield" else []
            yield from ((node.lineno, name) for name in names or [module])
        elif isinstance(node, ast.Import):
            yield from ((node.lineno, alias.name) for alias in node.names)


@pytest.mark.parametrize("file", FILES, ids=lambda f: str(f.relative_to(ROOT)))
def test_imports_only_go_down(file: Path) -> None:
    room, wrong = room_of(file), []
    assert room in FLOOR, f"{room} has no floor: give it one in FLOORS"
    for line, name in imports_of(file):
        package, _, rest = name.partition(".")
        target = ROOMS.get(first := rest.split(".")[0], first)
        if package == "skinfield":
            if target != room and FLOOR[target] <= FLOOR[room]:
                wrong.append(f"{file.name}:{line} {room} imports {target}")
        elif package not in sys.stdlib_module_names | CORE and room not in ELSEWHERE.get(
            package, set()
        ):
            wrong.append(f"{file.name}:{line} {room} imports {package}")
    assert not wrong, "\n".join(wrong)


def test_the_walk_sees_an_upward_arrow(tmp_path: Path) -> None:
    file = tmp_path / "bad.py"
    file.write_text("def f():\n    from skinfield.solve import Tikhonov\n    import click\n")
    assert [name for _, name in imports_of(file)] == ["skinfield.solve", "click"]
