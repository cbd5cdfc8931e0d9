"""Compiled code comes out of its file without all that Numba can compile, and Numba can still compile afterwards."""

import importlib.util
import subprocess
import sys

import numpy as np
import pytest
from numba import njit
from numba.core.caching import FunctionCache
from vvdp.simulation.loading import registries_left_out

pytestmark = pytest.mark.thorough

SECOND_RUN = """
import sys
import numpy as np
from vvdp.simulation.run import simulate
from vvdp.systems.system import load_system
system = load_system("prototype", until="0.01 s")
simulate(system.model, system.case, system.stepping)
print([name for name in ("pint", "scipy.linalg", "numba.np.linalg") if name in sys.modules])
from numba import njit
print(njit(lambda a, b: np.linalg.solve(a, b) + 0.0 * np.random.random())(np.eye(2), np.ones(2)))
"""

KEPT = """
from numba import njit
@njit("float64(float64)", cache=True)
def doubled(x):
    return 2.0 * x
"""


def test_a_second_run_loads_no_compiler_of_arrays():
    for _ in range(2):
        found = subprocess.run([sys.executable, "-c", SECOND_RUN], capture_output=True, text=True, check=True)
    assert found.stdout.splitlines() == ["[]", "[1. 1.]"]


def executed(folder):
    """The function of a module that is read anew; known by name, so that what Numba keeps of it is no copy of all."""
    spec = importlib.util.spec_from_file_location("kept_for_a_test", folder / "kept.py")
    module = sys.modules[spec.name] = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module.doubled


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "kept.py").write_text(KEPT)
    executed(tmp_path)
    return tmp_path


def test_reads_what_is_kept(folder):
    with registries_left_out():
        doubled = executed(folder)
    assert doubled(3.0) == 6.0 and sum(doubled.stats.cache_hits.values()) == 1


def test_numbas_own_way_where_its_inside_is_another(folder, monkeypatch):
    usual, calls = FunctionCache._load_overload, []

    def fails_first(self, signature, context):
        calls.append(signature)
        if len(calls) == 1:
            raise AttributeError("as in a version of another year")
        return usual(self, signature, context)

    monkeypatch.setattr(FunctionCache, "_load_overload", fails_first)
    with registries_left_out():
        doubled = executed(folder)
    assert doubled(3.0) == 6.0 and len(calls) == 2 and sum(doubled.stats.cache_hits.values()) == 1
    monkeypatch.delattr("numba.core.caching.FunctionCache")
    with registries_left_out():
        pass


def test_numba_is_left_as_it_was():
    before = FunctionCache.load_overload, dict(vars(FunctionCache))
    with pytest.raises(ZeroDivisionError), registries_left_out():
        raise ZeroDivisionError
    assert (FunctionCache.load_overload, dict(vars(FunctionCache))) == before
    first, second = registries_left_out(), registries_left_out()
    first.__enter__(), second.__enter__()
    first.__exit__(None, None, None)  # as in two threads, which do not end in turn
    assert FunctionCache.load_overload is not before[0]
    second.__exit__(None, None, None)
    assert (FunctionCache.load_overload, dict(vars(FunctionCache))) == before
    with registries_left_out():
        assert njit(lambda a: np.sort(a)[0])(np.array([2.0, 1.0])) == 1.0
