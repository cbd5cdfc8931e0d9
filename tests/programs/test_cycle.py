"""The program `cycle`: points and triangles over time, and what is refused of them."""

import numpy as np
import pytest
from tests.words import wording

from vvdp.base.errors import ConfigError, ParameterError
from vvdp.base.tables import parsed_table
from vvdp.programs.pulses import CycleTable, Now, cycle_of, cycle_step, cycle_value
from vvdp.simulation.run import simulate
from vvdp.systems.system import built_system

TRIANGLE = CycleTable(lower_end=0.05, stroke=0.216, stroke_time=4.0)
POINTS = CycleTable(times=(0.0, 4.0, 8.0), values=(0.05, 0.05 + 0.216, 0.05))
TIMES = np.linspace(0.0, 20.0, 1001)


def test_a_triangle_is_its_points():
    """To the last bit; 21.6 cm in 4 s are 5.4 cm after 1 s and on the way back after 7 s."""
    assert [cycle_value(float(t), cycle_of(TRIANGLE)) for t in TIMES] == [
        cycle_value(float(t), cycle_of(POINTS)) for t in TIMES
    ]
    assert [cycle_value(t, cycle_of(TRIANGLE)) for t in (1.0, 4.0, 7.0, 8.0)] == pytest.approx(
        [0.104, 0.266, 0.104, 0.05]
    )


@pytest.mark.parametrize("cycle", [TRIANGLE, POINTS], ids=["triangle", "points"])
def test_it_is_followed_once_and_read_ahead(cycle):
    values = {name: getattr(cycle, name) for name in ("times", "values", "lower_end", "stroke", "stroke_time")}
    once, early = cycle_of(CycleTable(**values, repeats=0.0)), cycle_of(CycleTable(**values, preview=0.5))
    assert [cycle_value(t, once) for t in (1.0, 8.5, 100.0)] == pytest.approx([0.104, 0.05, 0.05])
    assert cycle_value(0.5, early) == cycle_value(1.0, cycle_of(cycle))


def test_a_value_that_holds_is_that_of_the_middle():
    held = CycleTable(lower_end=0.05, stroke=0.216, stroke_time=4.0, preview=1.0, sample_period=0.2)
    _, command = cycle_step(0.0, (), Now(2.0), cycle_of(held))
    assert command.value == pytest.approx(0.05 + 0.216 * 3.1 / 4.0)
    assert command.start == pytest.approx(0.104)  # at time 0, read ahead


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({}, "stroke"),
        ({"stroke": 1.0}, "stroke_time"),
        ({"stroke": -1.0, "stroke_time": 1.0}, "stroke"),
        ({"times": (0.0, 1.0), "values": (0.0, 1.0), "stroke_time": 1.0}, "give them, or times and values"),
        ({"times": (0.0, 1.0), "values": (0.0, 1.0), "repeats": 0.5}, "repeats: 0.5 must be 0 or 1"),
        ({"times": (0.0, 1.0), "values": (0.0,)}, "1 for 2 times"),
        ({"values": (0.0, 1.0)}, "2 for 0 times"),
    ],
)
def test_what_is_no_cycle_is_refused(values, message):
    with pytest.raises(ParameterError, match=message):
        CycleTable(**values)


TEXT = """
title = "A pressure that follows a triangle"

[nodes]
tank = { type = "tank" }
line = { type = "volume", volume = "1 l", start = "0 bar" }

[components]
pump = { type = "flow-source", a = "tank", b = "line", flow = "0 lpm" }

[programs.course]
type = "cycle"
lower_end = "1 bar"
stroke = "20 bar"
stroke_time = "10 ms"

[run]
until = "20 ms"
sample_period = "1 ms"
"""


def test_a_stroke_is_a_difference():
    """From 1 to 21 bar over the atmosphere: the end is a level, the stroke is not."""
    found = built_system(parsed_table(TEXT, "mine.toml"), "mine")
    run = simulate(found.circuit.model, found.circuit.case, found.stepping)
    assert np.max(run.command.course.value) == pytest.approx(101325.0 + 21e5, rel=1e-12)
    with pytest.raises(ConfigError) as refused:
        built_system(parsed_table(TEXT.replace("20 bar", "0 bar"), "mine.toml"), "mine")
    (fault,) = refused.value.faults
    assert fault.key == "programs.course.stroke"
    assert wording.files.must_be_greater_than_zero.format(value="0 bar") in fault.message
