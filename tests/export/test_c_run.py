"""Programs in C on what a run has measured: every memory and command of the run, to the last bit."""

from dataclasses import replace

import numpy as np
import pytest
from tests.generator.c_way import c_entries, compilers

from vvdp.export.c_parts import module_of, program_entry
from vvdp.export.c_powers import C_INTRINSICS
from vvdp.generator.binding import is_fused
from vvdp.simulation.layout import command_parts, memory_parts
from vvdp.simulation.run import outputs, simulate
from vvdp.simulation.values import as_series, flat, leaves
from vvdp.systems.system import load_system


def _paths(system, program):
    """What a program reads by paths."""
    return [each for each in system.circuit.network.programs[program].reads.values() if isinstance(each, str)]


@pytest.mark.thorough
@pytest.mark.skipif(not compilers(), reason="no C compiler")
@pytest.mark.skipif(not is_fused(), reason="a run has other bits on a processor without fused operations")
@pytest.mark.parametrize(
    ("name", "program", "until"),
    [("prototype", "estimate", "1 s"), ("displacement-chapter6", "control", "2 s"), ("linear-valves", "loop", "0.5 s")],
)
def test_samples_of_a_run_have_the_same_bits(name, program, until):
    """Rows are at the samples only, since other instants are the same but for rounding.

    A row at the instant of a sample has the state that is measured; the next row has what has come of it, the commands
    included that other programs give at this instant.
    """
    system = load_system(name, (), until)
    period = system.model.programs[program].period or system.stepping.sample_period
    run = simulate(system.model, system.case, replace(system.stepping, record_interval=period, window=0.0))
    instants = np.arange(round(run.end / period)) * period
    rows = np.searchsorted(run.times, instants - 1e-9)
    assert run.times[rows].tolist() == instants.tolist()
    reads_commands = any(source.partition(".")[0] in system.model.programs for source in _paths(system, program))
    given = run.states[rows], run.commands[rows + 1 if reads_commands else rows]
    found = outputs(system.model, system.case, instants, *given)
    measure = system.model.programs[program].measure
    reading = measure(instants, as_series(system.case.state, given[0]), found, system.case.params)
    readings = np.stack([np.broadcast_to(leaf, instants.shape) for _, leaf, _ in leaves(reading)], axis=1)
    memories = run.memories[:, memory_parts(system.case)[program]][rows + 1]
    commands = run.commands[:, command_parts(system.case)[program]][rows + 1]
    entry = program_entry(system.model, system.case, program)
    step = c_entries(module_of([entry]), compilers()[0], ("-O2",), C_INTRINSICS)[entry.name]
    values = {block.name: flat(block.value) for block in entry.arguments}
    for number, t in enumerate(instants):
        values["reading"][:] = readings[number]
        step(t, *(values[block.name] for block in entry.arguments))
        assert values["memory"].tobytes() == memories[number].tobytes(), number
        assert values["command"].tobytes() == commands[number].tobytes(), number
    assert len({row.tobytes() for row in memories}) > 300
