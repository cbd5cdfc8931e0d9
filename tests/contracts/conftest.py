import ast
import importlib
import inspect
import pkgutil
from collections.abc import Callable
from functools import cache
from pathlib import Path
from types import ModuleType

import pytest

import vvdp

SOURCE = Path(vvdp.__file__).parent
ROOT = Path(__file__).parents[2]


@cache
def tree_of(path: Path) -> ast.Module:
    """What stands in a file of Python, read once for all contracts."""
    return ast.parse(path.read_text("utf-8"))


def modules_of(package: str) -> list[ModuleType]:
    found = importlib.import_module(f"vvdp.{package}")
    names = [info.name for info in pkgutil.iter_modules(found.__path__)]
    return [importlib.import_module(f"vvdp.{package}.{name}") for name in names]


def own_classes(module: ModuleType) -> list[type]:
    return [c for c in vars(module).values() if isinstance(c, type) and c.__module__ == module.__name__]


def public_functions(module: ModuleType) -> dict[str, Callable[..., object]]:
    members = inspect.getmembers(module, inspect.isfunction)
    return {n: f for n, f in members if f.__module__ == module.__name__ and not n.startswith("_")}


@pytest.fixture(scope="session")
def source() -> Path:
    """The package's folder."""
    return SOURCE


@pytest.fixture(scope="session")
def root() -> Path:
    """The repository."""
    return ROOT


@pytest.fixture(scope="session")
def formula_modules() -> list[ModuleType]:
    return [m for package in ("fluid", "valve", "hydraulics") for m in modules_of(package)]


@pytest.fixture(scope="session")
def value_classes() -> list[type]:
    """Every parameter class and every NamedTuple of values."""
    from vvdp.base import conservation
    from vvdp.base.params import Params
    from vvdp.simulation import stepping

    packages = ("fluid", "valve", "hydraulics", "sensing", "geometry", "estimation", "estimation.baselines")
    packages += ("control", "network", "components", "programs", "systems", "evaluation", "machines", "rivals")
    packages += ("programs.machine",)
    modules = [m for p in packages for m in modules_of(p)] + [conservation, stepping]
    return [c for m in modules for c in own_classes(m) if issubclass(c, Params) or hasattr(c, "_fields")]


@pytest.fixture(scope="session")
def functions_of() -> Callable[[ModuleType], dict[str, Callable[..., object]]]:
    return public_functions
