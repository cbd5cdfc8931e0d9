"""Stands that the tests of rigs share."""

import pytest

from vvdp.rigs.stand import Stand, stand
from vvdp.systems.system import load_system


@pytest.fixture(scope="session")
def source_stand() -> Stand:
    """The prototype against a source that holds the load pressure."""
    return stand(load_system("prototype-constant-load"))


@pytest.fixture(scope="session")
def orifice_stand() -> Stand:
    """The prototype with its load line and orifice."""
    return stand(load_system("prototype"))
