"""Comparator, sequence of stages and supervision, against numbers worked out by hand, and a press that uses them."""

import re
from pathlib import Path

import numpy as np
import pytest

import vvdp
from vvdp.base.errors import ParameterError
from vvdp.programs.filters import Read
from vvdp.programs.stages import (
    Bounds,
    Conditions,
    Levels,
    Stages,
    Watched,
    comparator_step,
    level_start,
    sequence_step,
    stage_start,
    supervision_step,
    watch_start,
)
from vvdp.systems.library_examples import FOLDER

PAGE = Path(__file__).parents[2] / "docs" / "programs.md"
FILE = FOLDER / "programs" / "stages.toml"


def run_steps(step, start, settings, readings, interval=0.1):
    """The commands of readings, one after the other."""
    memory, found = start(settings), []
    for number, reading in enumerate(readings):
        memory, command = step(number * interval, memory, reading, settings)
        found.append(command)
    return found


def compared(settings, values):
    return [int(each.value) for each in run_steps(comparator_step, level_start, settings, map(Read, values))]


def test_comparator_keeps_what_it_gave_between_its_levels():
    assert compared(Levels(on_level=2.0, off_level=1.0), [1.5, 2.0, 1.5, 1.0, 1.5, 3.0]) == [0, 1, 1, 0, 0, 1]


def test_comparator_the_other_way_round():
    """On at 1 and below, off at 2 and above: that of -x with the levels -1 and -2."""
    values = [1.5, 1.0, 1.5, 2.0, 1.5, 0.0]
    found = compared(Levels(on_level=1.0, off_level=2.0), values)
    assert found == [0, 1, 1, 0, 0, 1]
    assert found == compared(Levels(on_level=-1.0, off_level=-2.0), [-each for each in values])


def test_one_level_for_both():
    assert compared(Levels(on_level=1.0, off_level=1.0), [0.9, 1.0, 1.0, 1.1, 0.9]) == [0, 1, 1, 1, 0]


def test_a_level_has_to_be_held():
    """Samples are 0.1 s apart: 0.2 s are reached at the third in a row; a break begins anew."""
    settings = Levels(on_level=1.0, off_level=0.0, hold_time=0.2)
    assert compared(settings, [2.0, 2.0, 0.5, 2.0, 2.0, 2.0, -1.0, -1.0, -1.0]) == [0, 0, 0, 0, 0, 1, 1, 1, 0]


def staged(settings, readings):
    found = run_steps(sequence_step, stage_start, settings, readings)
    return [(each.stage, each.value) for each in found], found[-1]


def test_a_stage_ends_by_its_condition_or_its_time():
    """The second condition comes at 0.1 s, while the first stage lasts, and is not looked at; 0.3 s end the second."""
    settings = Stages(values=(5.0, 7.0, 9.0), time_limits=(1.0, 0.3))
    no, first, second = Conditions(), Conditions(first=1.0), Conditions(second=1.0)
    found, last = staged(settings, [no, second, first, no, no, no, first])
    assert found == [(1, 5), (1, 5), (2, 7), (2, 7), (2, 7), (3, 9), (3, 9)]
    assert last.timed_out == 1.0 and last.time == pytest.approx(0.1)


def test_a_time_limit_leads_where_it_says():
    settings = Stages(values=(5.0, 7.0, 9.0), time_limits=(0.2, 0.3), after_time_limit=(3.0, 3.0))
    found, last = staged(settings, [Conditions()] * 4)
    assert found == [(1, 5), (1, 5), (3, 9), (3, 9)] and last.timed_out == 1.0


def test_with_a_time_limit_for_all_the_stages_repeat():
    settings = Stages(values=(0.0, 1.0), time_limits=(0.1, 0.2))
    found, last = staged(settings, [Conditions()] * 8)
    assert [stage for stage, _ in found] == [1, 2, 2, 1, 2, 2, 1, 2]
    assert last.timed_out == 5.0


def test_an_emergency_is_for_good():
    settings = Stages(values=(3.0, 4.0, 0.0), time_limits=(0.1, 0.1, 0.1))
    found, _ = staged(settings, [Conditions(), Conditions(emergency=1.0), *[Conditions(first=1.0)] * 5])
    assert [stage for stage, _ in found] == [1, 3, 3, 3, 3, 3, 3]


@pytest.mark.parametrize(
    ("values", "limits", "after", "said"),
    [
        ((1.0,), (), (), "0 for 1 values"),
        ((1.0, 2.0, 3.0), (1.0,), (), "1 for 3 values"),
        ((1.0, 2.0), (1.0,), (1.0, 2.0), "2 for 1 time_limits"),
        ((1.0, 2.0), (1.0,), (3.0,), "numbers of stages, 1 to 2"),
        ((1.0, 2.0), (1.0,), (1.5,), "numbers of stages, 1 to 2"),
    ],
)
def test_stages_that_do_not_fit_are_refused(values, limits, after, said):
    with pytest.raises(ParameterError, match=said):
        Stages(values=values, time_limits=limits, after_time_limit=after)


def test_the_first_value_beyond_for_too_long_is_reported():
    """The second is beyond from 0.1 s on and reports once that is longer than its 0.15 s, at 0.3; the first, beyond
    later and at once, does not replace it. 0.1 s is the interval before a sample, so 0.1 and 0.2 s have passed then."""
    settings = Bounds(first_highest=10.0, second_lowest=-1.0, second_patience=0.15)
    readings = [(0.0, 0.0), (0.0, -2.0), (0.0, -2.0), (20.0, -2.0), (20.0, 0.0)]
    found = run_steps(supervision_step, watch_start, settings, [Watched(*each) for each in readings])
    assert [each.alarm for each in found] == [0.0, 0.0, 2.0, 2.0, 2.0]
    assert found[-1].time == pytest.approx(0.2)


def test_what_is_not_a_number_is_beyond_any_limit():
    found = run_steps(supervision_step, watch_start, Bounds(), [Watched(0.0, 0.0, float("nan"))] * 2)
    assert [each.alarm for each in found] == [0.0, 3.0]


def ends(run):
    """When each stage of a run ends [s], and the last stage."""
    data = run.to_xarray()
    stage = data["commands.stages.stage"].values
    return data["time"].values[1:][np.diff(stage) != 0.0], stage[-1]


def test_the_press_goes_through_its_stages():
    """20 cm^2 by 12 L/min: 100 mm/s, by 6 L/min 50 mm/s back. Oil takes 1.3 % less room at 28 bar, its air included.
    While it moves, 5000 N and 5000 N s/m ask for 27.5 and 23.75 bar."""
    run = vvdp.load(str(FILE)).run()
    found, last = ends(run)
    shown = re.search(r"The stages end at ([\d., and]+) s\.", PAGE.read_text("utf-8"))[1]
    assert [f"{each:.3f}" for each in found] == re.findall(r"[\d.]+", shown) and last == 5.0
    assert found[0] == pytest.approx(1.0, rel=0.015) and found[2] - found[1] == pytest.approx(0.5, abs=1e-9)
    data = run.to_xarray()
    pressure = np.interp([0.9, 4.3], data["time"], data["states.chamber"] / 1e5) - 1.01325
    assert pressure == pytest.approx([27.5, 23.75], abs=0.05)


def test_too_high_a_pressure_ends_everything():
    """With a limit of 70 bar the guard is first; oil still flows into the chamber for the 3 ms of its patience."""
    run = vvdp.load(str(FILE), programs={"guard.first_highest": "70 bar"}).run()
    found, last = ends(run)
    data = run.to_xarray()
    assert last == 5.0 and len(found) == 2 and set(data["commands.guard.alarm"].values) == {0.0, 1.0}
    assert not np.any(data["commands.stages.value"].values[data["time"].values > found[1]])


def test_units_follow_from_what_is_read(tmp_path):
    """A level in another unit than what is read is refused with its line."""
    path = tmp_path / "press.toml"
    path.write_text(FILE.read_text().replace('on_level = "80 bar"', 'on_level = "80 mm"'))
    with pytest.raises(vvdp.VvdpError, match=r"press.toml:\d+: programs.is_pressed.on_level"):
        vvdp.load(str(path))
