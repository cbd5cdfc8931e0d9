"""A cycle for a cylinder out of a log."""

from pathlib import Path

import numpy as np
import pytest

from vvdp.base.errors import ConfigError
from vvdp.machines.recorded_cycle import recorded_cycle, with_cycle
from vvdp.programs.machine.cycle import cycle_position
from vvdp.systems.system import load_system

TIMES = np.arange(0.0, 8.0, 2e-3)
POSITIONS = 0.15 - 0.05 * np.cos(2.0 * np.pi * 0.15 * TIMES)


def write(path: Path, rows: list[str], head: str = "time [s],position [mm]") -> Path:
    path.write_text("\n".join([head, *rows]) + "\n", encoding="utf-8")
    return path


def rows_of(times, positions) -> list[str]:
    return [f"{t:.4f},{1e3 * x:.6f}" for t, x in zip(times, positions, strict=True)]


def test_thousands_of_rows_are_followed(tmp_path):
    log = write(tmp_path / "cycle.csv", rows_of(TIMES + 12.0, POSITIONS))
    system = with_cycle(load_system("displacement-control"), log)
    points = system.circuit.network.programs["displacement"].settings.points
    assert len(points.times) == TIMES.size
    assert cycle_position(3.333, points) == pytest.approx(np.interp(3.333, TIMES, POSITIONS), abs=1e-8)
    assert system.circuit.network.nodes["rod"].position == pytest.approx(0.1)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda t, x: (np.concatenate([t[:100], t[80:]]), np.concatenate([x[:100], x[80:]])), "row 101"),
        (lambda t, x: (t, np.where(np.arange(t.size) == 50, np.nan, x)), "row 51: no position"),
        (lambda t, x: (t, np.where(t > 4.0, x + 0.02, x)), r"row 2002: .* are asked for; pump and cylinder reach"),
        (lambda t, x: (np.where(t > 4.0, t + 3.0, t), x), "row 2002: 3.002 s after the row before"),
        (lambda t, x: (t, x + 0.2), "the cylinder goes from 0 to 300 mm"),
    ],
)
def test_what_cannot_be_followed_is_refused_with_its_row(tmp_path, change, message):
    log = write(tmp_path / "cycle.csv", rows_of(*change(TIMES, POSITIONS)))
    with pytest.raises(ConfigError, match=message):
        with_cycle(load_system("displacement-control"), log)


def test_a_log_without_positions_is_refused(tmp_path):
    with pytest.raises(ConfigError, match="position"):
        recorded_cycle(write(tmp_path / "cycle.csv", ["0,1", "1,2"], "time [s],pressure [bar]"))


def test_a_system_without_cylinder_is_refused(tmp_path):
    log = write(tmp_path / "cycle.csv", rows_of(TIMES, POSITIONS))
    with pytest.raises(ConfigError, match="prototype has no cylinder that follows a cycle"):
        with_cycle(load_system("prototype"), log)
