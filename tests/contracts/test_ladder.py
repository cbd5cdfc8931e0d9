"""A package imports only from rungs below its own, no module imports itself by way of others, light ones stay light."""

import ast
import subprocess
import sys
from pathlib import Path

import pytest
from tests.contracts.conftest import tree_of

RUNGS = [
    {"base"},
    {"fluid", "numerics", "results", "logs", "generator"},
    {"valve", "hydraulics", "sensing"},
    {"geometry", "estimation", "control"},
    {"simulation"},
    {"network"},
    {"components", "programs"},
    {"systems"},
    {"evaluation"},
    {"machines"},
    {"runs", "studies"},
    {"steady"},
    {"rigs", "design", "cfd", "offline", "export", "fitting"},
    {"rivals"},
    {"comparison"},
    {"report"},
    {"web", "workbench"},
    {"api"},
    {"reproduction"},
    {"cli"},
]
FACE = "api"
"""The rung of the package itself: `import vvdp` brings what its face offers."""
RUNG = {package: i for i, packages in enumerate(RUNGS) for package in packages}
HEAVY = {"llvmlite", "h5py", "matplotlib", "scipy", "pint", "casadi", "rich", "typer"}
# Modules that exist only for a library, and are themselves imported only where it is needed.
MADE_FOR = {
    ("fluid/modulus.py", "scipy"),
    ("generator/binding.py", "llvmlite"),
    ("logs/hdf5.py", "h5py"),
    ("logs/mat.py", "h5py"),
    ("simulation/in_place.py", "llvmlite"),
    ("simulation/lane_code.py", "llvmlite"),
    ("simulation/lane_values.py", "llvmlite"),
    ("simulation/stored_record.py", "h5py"),
}
READER = {"arrays", "body", "expressions", "joining", "operations", "statements", "unit", "words"}
RECURSIVE = {frozenset(f"vvdp.generator.{name}" for name in READER)}
"""The reader of a language: statements hold expressions, and a call in an expression reads the statements it calls."""
FIRST_RUNGS = {package for packages in RUNGS[:5] for package in packages}


def imports(path: Path, *, top_level_only: bool) -> set[str]:
    """Dotted names that a file imports."""
    tree = tree_of(path)
    nodes = tree.body if top_level_only else list(ast.walk(tree))
    found = set()
    for node in nodes:
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            assert not node.level, f"{path}: relative import"
            found |= {f"{node.module}.{alias.name}" for alias in node.names}
    return found


def climbs(importer: str, imported: set[str]) -> set[str]:
    """What a package named `importer` may not import of `imported`."""
    named = {(name.split(".") + [FACE])[1] for name in imported if name.split(".")[0] == "vvdp"}
    packages = {name if name in RUNG else FACE for name in named}
    return {p for p in packages if p != importer and RUNG[p] >= RUNG[importer]}


def module_name(path: Path, source: Path) -> str:
    """Dotted name of the module in a file."""
    parts = (source.name, *path.relative_to(source).with_suffix("").parts)
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


def imported_modules(imported: set[str], modules: set[str]) -> set[str]:
    """The modules that imports name, by themselves or by what they define."""
    return {name if name in modules else name.rpartition(".")[0] for name in imported} & modules


def cycles(graph: dict[str, set[str]]) -> set[frozenset[str]]:
    """Groups of modules each of which comes to all others of its group by imports."""
    reach = {}
    for start in graph:
        found, rest = set(), [start]
        while rest:
            new = graph[rest.pop()] - found
            found |= new
            rest += new
        reach[start] = found
    groups = (frozenset(m for m in reach[start] if start in reach[m]) for start in graph if start in reach[start])
    return set(groups)


def files(source: Path) -> list[tuple[str, Path]]:
    return [(path.relative_to(source).parts[0], path) for path in sorted(source.glob("*/**/*.py"))]


def test_every_package_has_a_rung(source):
    packages = {path.parent.name for path in source.glob("*/__init__.py")}
    assert packages <= set(RUNG)


def test_no_package_climbs(source):
    found = [
        f"{path.relative_to(source)} imports {sorted(up)}"
        for package, path in files(source)
        if (up := climbs(package, imports(path, top_level_only=False)))
    ]
    assert not found, "\n".join(found)


def test_a_climb_and_a_step_aside_would_be_seen():
    assert climbs("valve", {"vvdp.simulation.run"}) == {"simulation"}
    assert climbs("valve", {"vvdp.hydraulics.flow"}) == {"hydraulics"}
    assert climbs("simulation", {"vvdp"}) == climbs("simulation", {"vvdp.__version__"}) == {"api"}
    assert climbs("reproduction", {"vvdp"}) == set()
    assert climbs("simulation", {"vvdp.hydraulics.flow", "vvdp.base.kinds", "numpy"}) == set()


def test_no_module_imports_itself_by_way_of_others(source):
    """Imports for types and within functions count too; the package's face, which loads when asked, does not."""
    paths = {module_name(path, source): path for path in source.glob("*/**/*.py")}
    graph = {name: imported_modules(imports(path, top_level_only=False), {*paths}) for name, path in paths.items()}
    assert cycles(graph) == RECURSIVE


def test_a_cycle_would_be_seen():
    graph = {"a": {"b"}, "b": {"c"}, "c": {"b"}, "d": {"a"}, "e": {"e"}}
    assert cycles(graph) == {frozenset("bc"), frozenset("e")}
    assert imported_modules({"p.m.Name", "p.m", "p.n", "numpy"}, {"p.m", "p.n"}) == {"p.m", "p.n"}


def test_heavy_libraries_are_loaded_where_they_are_used(source):
    found = [
        f"{path.relative_to(source)} imports {name}"
        for package, path in files(source)
        if package in FIRST_RUNGS
        for name in imports(path, top_level_only=True)
        if name.split(".")[0] in HEAVY and (str(path.relative_to(source)), name.split(".")[0]) not in MADE_FOR
    ]
    assert not found, "\n".join(found)


def test_formulas_know_no_compiler(source):
    """Rungs 1 to 4 do not know what compiles them, but for the generator's own packages."""
    below_simulation = {package for packages in RUNGS[:4] for package in packages}
    found = [
        str(path)
        for package, path in files(source)
        if package in below_simulation - {"generator"}
        if any(name.split(".")[0] in ("llvmlite", "numba") for name in imports(path, top_level_only=False))
    ]
    assert not found


@pytest.mark.parametrize(
    "module",
    ["vvdp", "vvdp.base.kinds", "vvdp.fluid.mixture", "vvdp.valve.losses", "vvdp.hydraulics.volume",
     "vvdp.network.build", "vvdp.components.library", "vvdp.simulation.run", "vvdp.systems.system"],
)  # fmt: skip
def test_import_loads_nothing_heavy(module):
    """In a fresh interpreter: what the import brings along."""
    text = f"import sys, {module}; print(*sorted({HEAVY!r} & set(sys.modules)))"
    done = subprocess.run([sys.executable, "-c", text], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == ""
