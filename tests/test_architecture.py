"""The package reads in one direction: a room imports only rooms that stand below it."""

import ast
import importlib
import inspect
import pickle
import re
from pathlib import Path

import pytest

import rrrobot as rr

PACKAGE = Path(rr.__file__).parent
ROOT = Path(__file__).parent.parent
# Bottom first. A room is a folder, or a file of its own; a line of rooms is one layer.
LAYERS = (
    ("errors", "lazy"),
    ("checks", "files", "serial"),
    ("progress", "results"),
    ("rotations", "integrate", "inline"),
    ("canvas",),
    ("drawing",),
    ("drive",),
    ("contact",),
    ("robot",),
    ("kkt",),
    ("constraints",),
    ("rows",),
    ("models",),
    ("momentum",),
    ("simulation",),
    ("reduction", "orbits"),
    ("machines",),
    ("belly",),
    ("studies",),
    ("figures", "steering"),
    ("view",),
    ("escape",),
    ("lab",),
    ("paper",),
    ("cli",),
    ("__main__",),
)
LEVEL = {room: level for level, rooms in enumerate(LAYERS) for room in rooms}


def modules():
    """Dotted names within the package, and files, of all modules but the top's."""
    for path in sorted(PACKAGE.rglob("*.py")):
        name = ".".join(path.relative_to(PACKAGE).with_suffix("").parts)
        name = name.removesuffix(".__init__")
        if name != "__init__":
            yield name, path


MODULES = dict(modules())


def imported(path, *, types=True):
    """Modules of the package that a file imports anywhere; on request not for types alone."""
    tree = ast.parse(path.read_text())
    typing_only = {
        id(node)
        for block in ast.walk(tree)
        if isinstance(block, ast.If) and getattr(block.test, "id", "") == "TYPE_CHECKING"
        for node in ast.walk(block)
    }
    for node in ast.walk(tree):
        if id(node) in typing_only and not types:
            continue
        if isinstance(node, ast.ImportFrom) and (node.module or "").split(".")[0] == "rrrobot":
            parent = node.module.partition(".")[2]
            for alias in node.names:
                inner = f"{parent}.{alias.name}".lstrip(".")
                yield inner if inner in MODULES else parent
        elif isinstance(node, ast.Import):
            for alias in node.names:
                if alias.name.split(".")[0] == "rrrobot":
                    yield alias.name.partition(".")[2]


def test_every_room_has_its_layer():
    assert {name.split(".")[0] for name in MODULES} == set(LEVEL)


@pytest.mark.parametrize("name", MODULES)
def test_imports_point_down(name):
    room = name.split(".")[0]
    for target in imported(MODULES[name]):
        assert target, f"{name} imports the whole package"
        other = target.split(".")[0]
        assert other == room or LEVEL[other] < LEVEL[room], f"{name} imports {target}"


def test_no_circle_within_a_room():
    below = {
        name: set(imported(path, types=False)) & set(MODULES) - {name}
        for name, path in MODULES.items()
    }
    done = set()
    while below:
        free = [name for name, needs in below.items() if needs <= done]
        assert free, f"these import each other: {sorted(below)}"
        done.update(free)
        for name in free:
            del below[name]


def test_no_module_has_the_name_of_a_public_function():
    # Commands have the names of what they run; nobody imports those modules.
    names = {name.split(".")[-1] for name in MODULES if not name.startswith("cli.")}
    assert not [n for n in names & set(rr.__all__) if inspect.isfunction(getattr(rr, n))]


@pytest.mark.parametrize("name", MODULES)
def test_no_file_is_long(name):
    assert len(MODULES[name].read_text().splitlines()) <= 350


FACES = ("", *sorted(p.parent.name for p in PACKAGE.glob("*/__init__.pyi")))


@pytest.mark.parametrize("name", MODULES)
def test_what_is_kept_for_each_argument_is_bounded(name):
    for node in ast.walk(ast.parse(MODULES[name].read_text())):
        if isinstance(node, ast.FunctionDef) and ast.unparse(node.args):
            kept = {ast.unparse(mark).removeprefix("functools.") for mark in node.decorator_list}
            assert not kept & {"cache", "lru_cache(maxsize=None)"}, node.name


def face(room):
    return importlib.import_module(f"rrrobot.{room}".rstrip("."))


@pytest.mark.parametrize("room", FACES)
def test_public_names_are_declared_and_documented(room):
    package = face(room)
    assert package.__doc__
    assert set(package.__all__) <= set(dir(package))
    for name in package.__all__:
        item = getattr(package, name)
        assert item.__doc__, f"{room}.{name} has no docstring"
        assert item.__module__.startswith(package.__name__), f"{room} shows what is not its own"


@pytest.mark.parametrize("room", FACES[1:])
def test_no_module_of_a_room_has_the_name_of_a_public_function(room):
    modules = {p.stem for p in (PACKAGE / room).rglob("*.py")}
    assert not modules & set(face(room).__all__)


def test_the_top_is_what_scripts_need():
    errors = {name for name in rr.__all__ if issubclass(type(getattr(rr, name)), type)
              and issubclass(getattr(rr, name), Exception)}  # fmt: skip
    assert 35 <= len(set(rr.__all__) - errors) <= 64
    assert not {name for name in rr.__all__ if inspect.ismodule(getattr(rr, name))}
    used = set(re.findall(r"\brr\.([a-z_0-9A-Z]+)", (ROOT / "README.md").read_text()))
    assert used <= set(dir(rr))


def test_all_names_come_by_star_and_unknown_ones_say_where_they_are():
    names = {}
    exec("from rrrobot import *", names)
    assert set(rr.__all__) <= set(names) and "robot" not in names
    with pytest.raises(AttributeError, match=r"It is rrrobot\.orbits\.equilibrium\."):
        rr.equilibrium  # noqa: B018
    with pytest.raises(AttributeError, match="no attribute 'walk'"):
        rr.walk  # noqa: B018
    with pytest.raises(ImportError):
        exec("from rrrobot import walk")


def test_what_the_face_gives_pickles():
    for name in ("FullModel", "simulate", "RRRobotParameters", "ParameterError"):
        assert pickle.loads(pickle.dumps(getattr(rr, name))) is getattr(rr, name)


def test_importing_stays_light():
    import subprocess
    import sys

    code = "import sys, rrrobot; print(*sys.modules)"
    loaded = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    heavy = {
        "matplotlib",
        "meshcat",
        "yourdfpy",
        "xarray",
        "numba",
        "scipy",
        "tqdm",
        "click",
        "pinocchio",
    }
    assert not heavy & set(loaded.stdout.split())
