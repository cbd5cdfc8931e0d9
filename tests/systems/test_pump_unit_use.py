"""The shipped pump unit in a circuit of one's own: its duty ratio or its axial position, mistakes, and its numbers."""

import pytest

from vvdp.base.errors import ConfigError
from vvdp.base.tables import parsed_table
from vvdp.evaluation.summary import summary
from vvdp.evaluation.validity import broken_bounds
from vvdp.runs.result import run_result
from vvdp.runs.simulate import recorded_run
from vvdp.simulation.run import simulate
from vvdp.systems.system import built_system

TEXT = """
[nodes]
tank = { type = "tank" }
motor = { type = "driven-shaft", speed = "1800 rpm" }
line = { type = "volume", volume = "0.5 l", start = "50 bar" }

[components]
load = { type = "orifice", a = "line", b = "tank", area = "3 mm^2" }

[parts.unit]
type = "pump-unit"
load = "line"
tank = "tank"
shaft = "motor"
duty_ratio = "0.5"

[run]
until = "50 ms"
"""


def system_of(text):
    return built_system(parsed_table(text, "own.toml"), "own")


def position_of(text):
    """The axial position that the valve of the unit is given at first [m]."""
    valve = system_of(text).circuit.network.parts["unit_valve"]
    return valve.inputs["axial_position"]


def test_a_duty_ratio_stands_in_place_of_the_axial_position():
    """0.5 of a helix of 20 mm, and of one of 24 mm; `axial_position` is the part's own otherwise."""
    texts = TEXT, TEXT.replace('"0.5"', '"0.5"\nhelix_length = "24 mm"')
    for text, length in zip(texts, (20e-3, 24e-3), strict=True):
        function, (ratio, valve) = position_of(text).function, position_of(text).sources
        assert function(ratio.base, valve) == pytest.approx(0.5 * length)
    inside = TEXT.replace('duty_ratio = "0.5"\n', '\n[components.unit.valve]\nduty_ratio = "0.25"\n')
    assert position_of(inside).sources[0].base == 0.25
    assert position_of(TEXT.replace('duty_ratio = "0.5"', 'axial_position = "7 mm"')).base == pytest.approx(7e-3)


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        (
            'ratio = "0.5"',
            'ratio = "0.5"\naxial_position = "10 mm"',
            "own.toml:15: parts.unit.duty_ratio: contradicts axial_position",
        ),
        ("driven-shaft", "drivenshaft", "own.toml:4: nodes.motor: type 'drivenshaft' is unknown; did you mean"),
        ("[parts.unit]", "[components.unit]", "it is a part, which stands in a table [parts.unit]"),
        (
            'ratio = "0.5"',
            'ratio = { from = "line.pressure" }',
            "own.toml:15: parts.unit.duty_ratio: unit_valve.duty_ratio is a",
        ),
    ],
)
def test_a_mistake_is_told_with_its_line(old, new, told):
    with pytest.raises(ConfigError) as refused:
        system_of(TEXT.replace(old, new, 1))
    assert told in str(refused.value)


def test_a_spool_beyond_its_helix_is_doubted():
    """10 m over a helix of 20 mm is a duty ratio of 500."""
    system = system_of(TEXT.replace('duty_ratio = "0.5"', 'axial_position = "10 m"'))
    found = summary(system, simulate(system.model, system.case, system.stepping))
    assert any("duty ratio of unit: 500, outside" in words for words in broken_bounds(system, found))
    usual = system_of(TEXT)
    found = summary(usual, simulate(usual.model, usual.case, usual.stepping))
    assert not any("duty ratio" in words for words in broken_bounds(usual, found))


def test_the_page_has_the_numbers_of_the_valve():
    """Those that the terminal shows: frequency, opening and efficiency of the unit."""
    system = system_of(TEXT)
    result = run_result(recorded_run(system, simulate(system.model, system.case, system.stepping), []))
    labels = {row.label for row in result.listings["valves"].rows}
    assert {"unit PWM frequency", "unit efficiency, pump shaft to load"} <= labels
    shown = next(section.shows for section in result.sections if section.title == "Losses")
    assert "valves" in shown
