from collections.abc import Callable, Sequence
from functools import cache

import pytest

from vvdp.evaluation.summary import Summary, summary
from vvdp.simulation.run import Run, simulate
from vvdp.systems.system import load_system

Ran = Callable[..., tuple[Summary, Run]]


@cache
def _ran(name: str, settings: tuple[str, ...], until: str) -> tuple[Summary, Run]:
    system = load_system(name, settings, until=until)
    run = simulate(system.model, system.case, system.stepping)
    return summary(system, run), run


@pytest.fixture(scope="session")
def ran() -> Ran:
    """Summary and run of a shipped system with settings; the same one is run once."""

    def result(name: str, settings: Sequence[str] = (), until: str = "0.5 s") -> tuple[Summary, Run]:
        return _ran(name, tuple(settings), until)

    return result
