"""Architecture: rooms, their imports, circles between files, and names, as one test each."""

import ast
import re
import sys
from collections import defaultdict
from collections.abc import Mapping
from functools import cache
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import skinfield

FLOORS = [  # top floor first; rooms of one floor never import each other
    {"__main__"},
    {"cli"},
    {"page", "bridges"},
    {"lab", "record", "emulator"},
    {"loop"},
    {"robot"},
    {"wire"},
    {"files"},
    {"calibrate"},
    {"reconstruct"},
    {"design", "testing"},
    {"solve"},
    {"simulate"},
    {"signal", "estimate"},
    {"elastic", "ring"},
    {"skin"},
    {"plot", "settings", "compile_progress"},
    # modules, not rooms, as are those above: what everyone needs
    {"errors", "compiled", "processes"},
]
FLOOR = {room: floor for floor, rooms in enumerate(FLOORS) for room in rooms}
ABOVE_CORE = {"__main__", "cli", "page", "bridges", "lab", "record", "emulator", "loop"}
CORE = {"numpy", "scipy", "numba"}
ELSEWHERE = {  # third-party packages outside the core, and the rooms that may import them
    "llvmlite": {"compiled", "solve"},  # the half of Numba that writes machine code
    "rich": {"cli"},
    "cyclopts": {"cli"},
    "msgspec": {"bridges", "files", "lab", "settings"},
    "tomli_w": {"cli", "signal"},
    "threadpoolctl": {"cli"},
    "matplotlib": {
        "plot",
        "skin",
        "calibrate",
        "cli",
        "estimate",
        "simulate",
        "design",
        "signal",
        "lab",
    },
    "contourpy": {"estimate", "simulate"},
    "pandas": {"estimate"},
    "pyarrow": {"estimate", "files"},
    "zarr": {"files"},
    "xarray": {"files"},  # the type that open_results returns
    "dask": {"files"},
    "distributed": {"cli"},
    "skfem": {"lab"},
    "trimesh": {"robot", "simulate"},
    "h5py": {"files"},
    "PIL": {"files", "plot", "simulate"},  # comes with matplotlib
    "can": {"wire"},
    "serial": {"wire"},
    "mcap": {"files"},
    "zstandard": {"files"},
    "lz4": {"files"},  # comes with mcap
    "rosbags": {"files"},
    "websockets": {"page"},
    "xxhash": {"bridges"},
    "zenoh": {"bridges"},
    "rclpy": {"bridges"},  # comes with ROS 2, never from PyPI
    "jinja2": {"lab"},
    "pytest": {"signal", "solve"},  # the contracts are tests
}
ALLOWED = {
    room: {package for package, rooms in ELSEWHERE.items() if room in rooms} for room in FLOOR
}
SAY_NOTHING = {  # words of speech and participles that do not say what a thing is
    "told", "tells", "said", "kept", "given", "found", "shown", "beside", "asked", "done", "again",
    "laid", "steady", "seen", "answered", "unanswered", "early",
}  # fmt: skip
NO_NOUN = re.compile(r"(What|How|Whether|Where|When|Who|Which|From|To|On|In|As|It|All|If|By)\b")
ROOT = Path(skinfield.__file__).parent
FILES = {
    ".".join(file.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__"): file
    for file in sorted(ROOT.rglob("*.py"))
    if file != ROOT / "__init__.py"
}


@cache
def tree_of(file: Path) -> ast.Module:
    return ast.parse(file.read_text(), str(file))


@cache
def imports_of(file: Path) -> list[tuple[int, str]]:
    """Line and full name of whatever a file imports, nested and under TYPE_CHECKING, too."""
    names = []
    for node in ast.walk(tree_of(file)):
        if isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{file}:{node.lineno} imports relatively"
            names += [(node.lineno, f"{node.module}.{alias.name}") for alias in node.names]
        elif isinstance(node, ast.Import):
            names += [(node.lineno, alias.name) for alias in node.names]
    return names


def module_of(name: str) -> str:
    """Module of ours that a full name is in; empty for none."""
    parts = name.split(".")[1:] if name.startswith("skinfield.") else []
    for end in range(len(parts), 0, -1):
        if (module := ".".join(parts[:end])) in FILES:
            return module
    return ""


def wrong_imports(room: str, file: Path) -> list[str]:
    """Imports that do not go down, or of packages that the room shall do without."""
    wrong = []
    for line, name in imports_of(file):
        package, _, rest = name.partition(".")
        target = rest.split(".")[0]
        if package == "skinfield" and target in FLOOR:
            if target != room and FLOOR[target] <= FLOOR[room]:
                wrong.append(f"{file.name}:{line} {room} imports {target}")
        elif package not in sys.stdlib_module_names | CORE | {"skinfield"} | ALLOWED[room]:
            wrong.append(f"{file.name}:{line} {room} imports {package}")
    return wrong


def circle_of(arrows: Mapping[str, set[str]]) -> list[str]:
    """Nodes of a circle of a graph, in their order; empty where there is none."""
    try:
        TopologicalSorter(arrows).prepare()
    except CycleError as error:
        return sorted(set(error.args[1]))
    return []


def test_what_rooms_may_import_they_do() -> None:
    used = defaultdict(set)
    for module, file in FILES.items():
        for _, name in imports_of(file):
            used[name.partition(".")[0]].add(module.split(".")[0])
    assert {package: used[package] for package in ELSEWHERE} == ELSEWHERE


def test_imports_only_go_down() -> None:
    rooms = {module.split(".")[0] for module in FILES}
    assert rooms == set(FLOOR), "every room has its floor in FLOORS, and no floor has ghosts"
    assert len({room for room in rooms if (ROOT / room).is_dir()}) <= 20
    wrong = [
        text for module, file in FILES.items() for text in wrong_imports(module.split(".")[0], file)
    ]
    assert not wrong, "\n".join(wrong)
    highest = min(FLOOR[room] for room in rooms - ABOVE_CORE)
    assert highest > max(FLOOR[room] for room in ABOVE_CORE), "core is below live and lab"


def test_no_files_import_each_other_in_a_circle() -> None:
    arrows = defaultdict(set)
    for module, file in FILES.items():
        arrows[module] = {module_of(name) for _, name in imports_of(file)} - {module, ""}
    assert circle_of({"a": {"b"}, "b": {"c"}, "c": {"b"}}) == ["b", "c"]
    assert circle_of(arrows) == []


def test_a_file_is_one_concept_of_at_most_600_lines() -> None:
    lengths = {module: len(file.read_text().splitlines()) for module, file in FILES.items()}
    assert {module: length for module, length in lengths.items() if length > 600} == {}
    assert len(FILES) <= 450


def test_module_docstrings_begin_with_what_one_would_search_for() -> None:
    first = {
        module: (ast.get_docstring(tree_of(file)) or "What?").splitlines()[0]
        for module, file in FILES.items()
    }
    assert {module: text for module, text in first.items() if NO_NOUN.match(text)} == {}


def test_names_say_what_things_are() -> None:
    wrong = [module for module in FILES if module.split(".")[-1] in SAY_NOTHING]
    for module, file in FILES.items():
        for node in ast.walk(tree_of(file)):
            names = []
            if isinstance(node, ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef):
                names = [node.name]
            if isinstance(node, ast.ClassDef):
                fields = [part.target for part in node.body if isinstance(part, ast.AnnAssign)]
                names += [field.id for field in fields if isinstance(field, ast.Name)]
            wrong += [f"{module}.{n}" for n in names if n.strip("_").lower() in SAY_NOTHING]
    assert not wrong
