"""Tables inside of a table: read with their lines, chosen by their keys, left out where they may be."""

import pytest

from vvdp.base.kinds import Length, Time
from vvdp.base.params import Params
from vvdp.base.rules import require_positive
from vvdp.base.slots import inner_slots
from vvdp.base.tables import build, parsed_table


class Triangle(Params):
    stroke: Length
    stroke_time: Time

    def check(self) -> None:
        require_positive(self, "stroke_time")


class Ramp(Params):
    stroke: Length
    speed_time: Time


class Filter(Params):
    lag: Time = 0.5


class Control(Params):
    cycle: Triangle | Ramp
    filter: Filter = Filter()
    guard: Filter | None = None
    period: Time


TEXT = """[control]
period = "1 ms"

[control.cycle]
stroke = "10 mm"
stroke_time = "2 s"
"""


def read(text):
    table, faults = parsed_table(text, "mine.toml"), []
    found, rows = build(Control, table.content["control"], "control", table, faults)
    return found, rows, [str(fault) for fault in faults]


def test_an_inner_table_is_read_with_its_own_path():
    found, rows, faults = read(TEXT)
    assert faults == [] and found == Control(cycle=Triangle(stroke=0.01, stroke_time=2.0), period=1e-3)
    assert [row.setting for row in rows] == ["control.period", "control.cycle.stroke", "control.cycle.stroke_time"]


def test_the_keys_choose_the_class_of_a_table():
    found, _, faults = read(TEXT.replace("stroke_time", "speed_time"))
    assert faults == [] and found.cycle == Ramp(stroke=0.01, speed_time=2.0)


def test_optional_tables_have_their_values_if_they_are_given():
    found, rows, faults = read(TEXT + '\n[control.guard]\n\n[control.filter]\nlag = "1 s"\n')
    assert faults == [] and (found.guard, found.filter) == (Filter(lag=0.5), Filter(lag=1.0))
    assert [(row.setting, row.note) for row in rows[3:]] == [
        ("control.filter.lag", ""),
        ("control.guard.lag", "default"),
    ]
    assert {name: slot.optional for name, slot in inner_slots(Control).items()} == {
        "cycle": False,
        "filter": True,
        "guard": True,
    }


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ('[control]\nperiod = "1 ms"\n', "mine.toml:1: control.cycle: missing table"),
        ('[control]\nperiod = "1 ms"\ncycle = 3\n', "mine.toml:3: control.cycle: 3 is not a table"),
        (TEXT + 'speed_time = "1 s"\n', "mine.toml:7: control.cycle.speed_time: contradicts cycle.stroke_time"),
        (TEXT.replace('"2 s"', '"0 s"'), "mine.toml:6: control.cycle.stroke_time: '0 s' = 0 ms must be greater than 0"),
        (TEXT + 'strok = "1 mm"\n', "mine.toml:7: control.cycle.strok: unknown key; did you mean 'stroke'?"),
        (TEXT.replace("stroke_time", "strok_time"), "control.cycle.stroke_time: missing key 'stroke_time'"),
    ],
)
def test_what_is_wrong_in_an_inner_table_is_reported_at_its_line(text, told):
    found, _, faults = read(text)
    assert found is None and any(told in fault for fault in faults), faults
