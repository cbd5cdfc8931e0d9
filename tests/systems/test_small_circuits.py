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


def test_gas_fast_and_slowly(ran):
    title = "Compressing a gas fast and slowly"
    done, quick = ran(title), ran(title, "components.accumulator.heat_time=1000 s")
    for each in (done, quick):
        check_closed(each)
    first = 1e7 + 101325.0
    V = 1e-3 / done.run.state.accumulator.compression[-1]
    assert pytest.approx(0.604e-3, abs=5e-7) == V
    assert done.run.state.line[-1] == pytest.approx(first * 1e-3 / V, rel=1e-3)
    assert done.run.state.accumulator.gas_temperature[-1] == pytest.approx(293.15, abs=0.1)
    least = 1e-3 / np.max(quick.run.state.accumulator.compression)
    assert quick.found["pressure_max_line_Pa"] + 101325.0 == pytest.approx(first * (1e-3 / least) ** 1.4, rel=1e-3)
    real = ran(title, "components.accumulator.real_gas=1")
    check_closed(real)
    assert real.run.state.line[-1] == pytest.approx(170.3e5 + 101325.0, rel=1e-3)


def test_behind_a_piston(ran):
    done = ran("Behind a piston")
    check_closed(done)
    P0, P = 101325.0, 150e5 + 101325.0
    V = (100e5 + P0) * 1e-3 / P
    assert done.run.state.piston.position[-1] == pytest.approx((1e-3 - V) / 5e-3, rel=1e-3)
    assert done.run.state.spring_piston.position[-1] == pytest.approx(0.05, rel=1e-3)
