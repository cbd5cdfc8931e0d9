"""FMUs in FMPy: no problem is found in the description, and all states have the bits of a run."""

import importlib

import fmpy
import fmpy.validation as validation
import numpy as np
import pytest
from tests.export.builds import made
from tests.export.test_fmu import PERIOD, paths_of, pytestmark, run_of

from vvdp.systems.system import load_system

__all__ = ["pytestmark"]


@pytest.fixture
def path(tmp_path):
    """A function that writes the FMU of a system."""

    def write(name, fmi):
        file = tmp_path / f"{name}-{fmi}.fmu"
        file.write_bytes(made(name, fmi).content)
        return str(file)

    return write


@pytest.mark.parametrize(
    ("name", "fmi"),
    [
        ("prototype", 2),
        ("prototype", 3),
        ("displacement-chapter6", 3),
        pytest.param("displacement-chapter6", 2, marks=pytest.mark.thorough),
    ],
)
def test_nothing_is_wrong_and_no_state_differs(name, fmi, path):
    """At communication steps of 1 and 5 ms, over 0.2 s."""
    file = path(name, fmi)
    assert validation.validate_fmu(file) == []
    run, paths = run_of(name, 0.2), paths_of(load_system(name))
    for every in (1, 5):
        found = fmpy.simulate_fmu(file, stop_time=0.2, output_interval=every * PERIOD)
        rows = np.stack([found[path] for path in paths], axis=1)
        assert rows.tobytes() == run.states[::every, : len(paths)].tobytes()


def test_a_start_value_is_that_of_a_run_with_set(path):
    run = run_of("prototype", 0.1, ['load.area="4 mm^2"'])
    area = next(row.nominal for row in run_rows() if row.setting == "load.area")
    found = fmpy.simulate_fmu(path("prototype", 3), stop_time=0.1, output_interval=PERIOD,
                              start_values={"load.area": area})  # fmt: skip
    assert found["load_line"].tobytes() == run.states[:, 0].tobytes()
    with pytest.raises(Exception, match="error"):
        fmpy.simulate_fmu(path("prototype", 3), stop_time=0.1, start_values={"load.area": float("nan")})


def run_rows():
    return load_system("prototype", ['load.area="4 mm^2"']).rows


@pytest.mark.parametrize("name", ["prototype", "displacement-chapter6"])
def test_event_mode_shows_each_sample_before_and_after(name, path):
    """Two rows at each sample: the state has the bits of a run in both, commands change between them."""
    run, paths = run_of(name, 0.2), paths_of(load_system(name))
    command = next(each for each in made(name, 3).model.outputs if each.vector == "command")
    for every in (1, 5):
        found = fmpy.simulate_fmu(path(name, 3), stop_time=0.2, output_interval=every * PERIOD,
                                  use_event_mode=True, early_return_allowed=True)  # fmt: skip
        states = np.stack([found[path] for path in paths], axis=1)
        assert len(found) == 2 * 200 + 1
        assert states[1::2].tobytes() == run.states[1:, : len(paths)].tobytes()
        assert states[2::2].tobytes() == run.states[1:, : len(paths)].tobytes()
        before, after = found[command.name][1::2], found[command.name][2::2]
        assert before[1:].tobytes() == after[:-1].tobytes()
        assert before.tobytes() == run.commands[1:, command.place].tobytes()


def test_libcosim_has_the_same_bits(path):
    """Half a second at 1 ms, FMI 2, where it is installed."""
    libcosimpy = pytest.importorskip("libcosimpy")
    execution, slave, observer = (
        importlib.import_module(f"{libcosimpy.__name__}.Cosim{name}") for name in ("Execution", "Slave", "Observer")
    )
    run, paths = run_of("prototype", 0.5), paths_of(load_system("prototype"))
    one = execution.CosimExecution.from_step_size(1_000_000)  # ns
    number = one.add_local_slave(slave.CosimLocalSlave(path("prototype", 2), "one"))
    last = observer.CosimObserver.create_last_value()
    one.add_observer(last)
    assert all(one.step() for _ in range(500))
    names = [each.name for each in made("prototype", 2).model.variables]
    found = last.last_real_values(number, [1 + names.index(each) for each in paths])
    assert np.array(found).tobytes() == run.final[: len(paths)].tobytes()
