"""docs/small-circuits.md: each file runs, its balances close, and it gives what follows by hand."""

import re
from functools import cache
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest

from vvdp.simulation.run import Run, simulate
from vvdp.systems.summary import Summary, summary
from vvdp.systems.system import load_system
from vvdp.systems.validity import broken_bounds

PAGE = (Path(__file__).parents[2] / "docs" / "small-circuits.md").read_text("utf-8")


class Done(NamedTuple):
    """A run and its summary."""

    run: Run
    found: Summary
    broken: list[str]


@pytest.fixture(scope="module")
def ran(tmp_path_factory):
    """Runs the file of a section of the page, with settings."""
    folder = tmp_path_factory.mktemp("circuits")

    @cache
    def done(title: str, *settings: str) -> Done:
        text = re.search(rf"^## {title}\n.*?```toml\n(.*?)```", PAGE, re.MULTILINE | re.DOTALL)[1]
        path = folder / f"{re.sub(r'[^a-z]+', '-', title.lower())}.toml"
        path.write_text(text, "utf-8")
        system = load_system(str(path), list(settings))
        run = simulate(system.model, system.case, system.stepping)
        found = summary(system, run)
        return Done(run, found, broken_bounds(system, found))

    return done


def check_closed(done: Done) -> None:
    """Both balances of a run close."""
    assert max(abs(done.found["energy_residual"]), abs(done.found["mass_residual"])) < 1e-6


def test_tank_cooler_filter(ran):
    done = ran("Tank, cooler, filter")
    check_closed(done)
    assert not done.broken
    end = done.run.outputs
    assert end.tank_level[-1] == pytest.approx(0.4 - 6 / 6e4 * 120 / 0.1, abs=5e-5)
    assert done.run.state.filter.clogging[-1] == pytest.approx(0.5, abs=5e-4)
    drop = done.run.state.between[-1] - done.run.state.behind[-1]
    assert drop == pytest.approx(2e5, rel=1e-3)
    assert done.found["level_min_tank_m"] == pytest.approx(end.tank_level[-1])


def test_a_tank_that_runs_dry_is_told(ran):
    covered = ran("Tank, cooler, filter", "components.drain.flow=40 lpm", "run.until=47 s")
    assert not covered.broken
    dry = ran("Tank, cooler, filter", "components.drain.flow=40 lpm", "run.until=48 s")
    assert not dry.found["within_validity"]
    assert any("its suction runs dry" in sentence for sentence in dry.broken)


def test_square_wave(ran):
    done = ran("A square wave in a line")
    check_closed(done)
    assert not done.broken
    assert done.found["pressure_max_end_Pa"] == pytest.approx(200e5, rel=2e-3)
    end = done.run.state.end - 101325.0 - 150e5
    assert np.sum(np.diff(np.sign(end)) != 0) == 12
    first = done.run.times > 25e-3
    assert np.min(done.run.state.end[first]) - 101325.0 == pytest.approx(100e5, rel=2e-3)
