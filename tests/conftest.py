"""What all tests share: system programs that may be missing."""

import os
import shutil
import sys

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
    message = f"NOT TESTED: {name} is not installed"
    if name in os.environ.get("VVDP_REQUIRE", "").split(","):
        pytest.fail(f"{message}, and VVDP_REQUIRE demands it")
    print(message, file=sys.stderr)
    return pytest.skip(message)


@pytest.fixture(scope="session")
def chromium() -> str:
    """Path of the browser."""
    return required_program("chromium")
