"""The package reads in one direction: each file imports only files that come before it."""

import ast
from pathlib import Path

import pytest

import rrrobot as rr

PACKAGE = Path(rr.__file__).parent
ORDER = [
    "errors",
    "checks",
    "files",
    "parameters",
    "rotations",
    "surfaces",
    "urdf_reader",
    "urdf",
    "joints",
    "example_robots",
    "robot",
    "gaits",
    "torques",
    "damping",
    "integrate",
    "rolling",
    "constraints",
    "models",
    "models.base",
    "models.full",
    "models.reduced",
    "models.pivoting",
    "models.single_axis",
    "momentum",
    "momentum.compiled",
    "momentum.trigonometry",
    "momentum.coefficients",
    "momentum.kernels",
    "momentum.setting",
    "momentum.vertical",
    "momentum.summary",
    "momentum.settle",
    "momentum.forces",
    "momentum.loads",
    "momentum.extremes",
    "momentum.batch",
    "momentum.run",
    "steady_state",
    "trajectory",
    "simulate",
    "decoupled",
    "closed_forms",
    "oscillations",
    "compare",
    "table4",
    "reduction",
    "reduction_yaw",
    "reduction_heights",
    "reduction_checks",
    "reduction_paths",
    "reduction_loops",
    "yaw_planner",
    "cycles",
    "sweep_store",
    "sweep_models",
    "sweep_plan",
    "sweep_progress",
    "sweep_job",
    "sweep",
    "optimise_table",
    "optimise_goals",
    "optimise_space",
    "optimise_task",
    "optimise_lanes",
    "optimise_result",
    "optimise_search",
    "optimise",
    "optimise_pareto",
    "figures",
    "figures.style",
    "figures.trajectory",
    "figures.comparison",
    "figures.pareto",
    "figures.reduction",
    "figures.maps",
    "figures.schematic",
    "figures.unicycle",
    "figures.paper",
    "reproduction",
    "reproduction.item",
    "reproduction.workshop",
    "reproduction.settled",
    "reproduction.yaw_balance",
    "reproduction.claims_travel",
    "reproduction.claims_reach",
    "reproduction.claims_axes",
    "reproduction.claims_yaw",
    "reproduction.claims_drift",
    "reproduction.claims",
    "reproduction.errata",
    "reproduction.tables",
    "reproduction.schematics",
    "reproduction.paths",
    "reproduction.planes",
    "reproduction.report",
    "reproduction.run",
    "meshcat_commands",
    "visuals",
    "scene",
    "film",
    "_meshcat_server",
    "viewer",
    "cli_types",
    "cli_options",
    "cli_report",
    "cli_build",
    "cli_compile",
    "cli_simulate",
    "cli_compare",
    "cli_optimise",
    "cli_reduce",
    "cli_reproduce",
    "cli_sweep_grids",
    "cli_sweep_report",
    "cli_sweep",
    "cli_view",
    "cli",
    "__main__",
]
# A convenience on the result object, loaded when it is called.
ALLOWED_UP = {("trajectory", "figures.trajectory")}


def modules():
    for path in sorted(PACKAGE.rglob("*.py")):
        name = ".".join(path.relative_to(PACKAGE).with_suffix("").parts)
        name = name.removesuffix(".__init__")
        if name != "__init__":
            yield name, path


def imported(path):
    """Modules of the package that a file imports anywhere but under TYPE_CHECKING."""
    tree = ast.parse(path.read_text())
    typing_only = {
        id(node)
        for block in ast.walk(tree)
        if isinstance(block, ast.If) and getattr(block.test, "id", "") == "TYPE_CHECKING"
        for node in ast.walk(block)
    }
    for node in ast.walk(tree):
        if id(node) in typing_only:
            continue
        if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("rrrobot"):
            if node.module == "rrrobot":
                yield from (alias.name for alias in node.names)
            else:
                yield node.module.removeprefix("rrrobot.")
        elif isinstance(node, ast.Import):
            for alias in node.names:
                if alias.name.startswith("rrrobot."):
                    yield alias.name.removeprefix("rrrobot.")


def test_every_file_has_its_place():
    assert sorted(ORDER) == sorted(name for name, _ in modules())


@pytest.mark.parametrize("name, path", list(modules()), ids=lambda v: str(v).split("/")[-1])
def test_imports_point_down(name, path):
    for target in imported(path):
        if (name, target) not in ALLOWED_UP:
            assert ORDER.index(target) < ORDER.index(name), f"{name} imports {target}"


def test_public_names_are_declared_and_documented():
    assert sorted(set(rr.__all__)) == sorted(rr.__all__)
    for name in rr.__all__:
        item = getattr(rr, name)
        assert item.__doc__, f"{name} has no docstring"


def test_importing_stays_light():
    import subprocess
    import sys

    code = "import sys, rrrobot; print(*sys.modules)"
    loaded = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    heavy = {"matplotlib", "meshcat", "yourdfpy", "xarray", "numba", "scipy", "tqdm", "click"}
    assert not heavy & set(loaded.stdout.split())
