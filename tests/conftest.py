"""What all tests share: programs and samples that may be missing."""

import os
import shutil
import sys
from collections.abc import Callable
from typing import NoReturn

import pytest
from hypothesis import settings

# Times of single examples say nothing on a shared machine; in continuous integration every run draws the same ones.
settings.register_profile("local", deadline=None)
settings.register_profile("ci", deadline=None, derandomize=True)
settings.load_profile("ci" if os.environ.get("CI") else "local")


def required_program(name: str) -> str:
    """Path of a system program. Where it is missing, skips, or fails if `VVDP_REQUIRE` names it."""
    if path := shutil.which(name):
        return path
    return not_tested(f"{name} is not installed", name)


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
def chromium() -> str:
    """Path of the browser."""
    return required_program("chromium")
