"""What all tests share: programs and samples that may be missing."""

import importlib.util
import os
import re
import shutil
import sys
from collections import Counter
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, NoReturn

import pytest
from hypothesis import settings

if TYPE_CHECKING:
    from vvdp.steady.test_stand import Stand
    from vvdp.systems.system import System

# Times of single examples say nothing on a shared machine. Every run draws the same ones; `--hypothesis-profile=search`
# draws others.
settings.register_profile("same", deadline=None, derandomize=True)
settings.register_profile("search", deadline=None)
settings.load_profile("same")


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Put heavy files first: the light ones fill what time is left at the end of a run.

    Of the cases of a test that is sampled(n), every nth stays in the short tests and the others are thorough ones.
    """
    items.sort(key=lambda item: item.get_closest_marker("heavy") is None)
    cases: Counter[str] = Counter()
    for item in items:
        if sampled := item.get_closest_marker("sampled"):
            test = item.nodeid.partition("[")[0]
            if cases[test] % sampled.args[0]:
                item.add_marker("thorough")
            cases[test] += 1


def required_program(name: str, word: str = "") -> str:
    """Path of a system program. Where it is missing, skips, or fails if `VVDP_REQUIRE` names it or `word`."""
    if path := shutil.which(name):
        return path
    return not_tested(f"{name} is not installed", word or name)


def not_tested(reason: str, word: str) -> NoReturn:
    """Skips with one line that says so, or fails if `VVDP_REQUIRE` names `word`."""
    message = f"NOT TESTED: {reason}"
    if word in os.environ.get("VVDP_REQUIRE", "").split(","):
        pytest.fail(f"{message}, and VVDP_REQUIRE demands it")
    print(message, file=sys.stderr)
    pytest.skip(message)


@pytest.fixture(scope="session", name="not_tested")
def not_tested_fixture() -> Callable[[str, str], NoReturn]:
    """`not_tested`, for the conftest of a folder."""
    return not_tested


@pytest.fixture(scope="session")
def source_stand() -> "Stand":
    """The prototype against a source that holds the load pressure."""
    from vvdp.steady.test_stand import stand
    from vvdp.systems.system import load_system

    return stand(load_system("prototype-constant-load"))


IDEAL = (
    "oil.pressure_viscosity=0 1/Pa",
    "pump.displacement=22.2222222 cc/rev",
    "pump.leakage_conductance=0 m^3/(s*Pa)",
    "relief_valve.override_pressure=0 bar",
    "valve.friction_area=2716 mm^2",
    "valve.jet_exponent=0",
    "valve.jet_asymmetry=0",
    "load.area=3.0463 mm^2",
)
"""With these the prototype with its load line is as ideal as the one against a source: pump and relief valve without
loss of their own, jets as wide as the nozzles."""


@pytest.fixture(scope="session")
def ideal_prototype() -> "System":
    """The prototype with its load line and orifice, `IDEAL`."""
    from vvdp.systems.system import load_system

    return load_system("prototype", IDEAL)


@pytest.fixture(scope="session")
def orifice_stand(ideal_prototype: "System") -> "Stand":
    """The ideal prototype with its load line and orifice."""
    from vvdp.steady.test_stand import stand

    return stand(ideal_prototype)


@pytest.fixture(scope="session")
def chromium() -> str:
    """Path of the browser."""
    return required_program("chromium")


DOCS = Path(__file__).parents[1] / "docs"


@pytest.fixture(scope="session")
def key_sections() -> Mapping[str, Any]:
    """docs/keys.md by verb, as its generator reads it; what all results have stands under no name."""
    found = importlib.util.spec_from_file_location("keys", DOCS / "site" / "keys.py")
    assert found is not None and found.loader is not None
    module = importlib.util.module_from_spec(found)
    found.loader.exec_module(module)
    return module.sections((DOCS / "keys.md").read_text("utf-8"))


@pytest.fixture(scope="session")
def keys_as_described(key_sections: Mapping[str, Any]) -> Callable[..., None]:
    """Holds what a verb has printed, at one time or several, against docs/keys.md.

    Every key is described, and every key that is described is there, but for those that the page says may be absent.
    """

    def check(verb: str, *printed: Iterable[str]) -> None:
        section = key_sections[verb]
        found = {key for each in printed for key in each}
        own = [section.pattern(key) for key in section.rows]
        known = own + [
            key_sections[other].pattern(key) for other in ("", *section.others) for key in key_sections[other].rows
        ]
        assert sorted(key for key in found if not any(re.fullmatch(each, key) for each in known)) == []
        always = [key for key, (*_, meaning) in section.rows.items() if not re.search(r"\bonly\b|\babsent\b", meaning)]
        assert [key for key in always if not any(re.fullmatch(section.pattern(key), each) for each in found)] == []

    return check
