"""Inputs that are what is read, per a value."""

import pytest

from vvdp.base.errors import ConfigError
from vvdp.base.tables import parsed_table
from vvdp.simulation.run import simulate
from vvdp.systems.system import built_system

TEXT = """
[nodes]
tank = {{ type = "tank" }}
supply = {{ type = "pressure-source", pressure = "100 bar" }}
line = {{ type = "volume", volume = "0.5 l", start = "20 bar" }}

[components.valve]
type = "proportional-valve"
a = "supply"
b = "line"
command = {share}
conductance = "1e-7 m^3/(s*Pa^0.5)"
leakage_conductance = "0 m^3/(s*Pa)"
transition_pressure = "0.5 bar"
lag = "5 ms"

[components.drain]
type = "orifice"
a = "line"
b = "tank"
area = "2 mm^2"

[programs.wanted]
type = "cycle"
times = ["0 s", "1 s", "2 s"]
values = ["10 lpm", "10 lpm", "10 lpm"]

[run]
until = "0.1 s"
"""


def built(share):
    return built_system(parsed_table(TEXT.format(share=share), "share.toml"), "share")


@pytest.mark.parametrize(
    ("share", "opening"),
    [
        ('{ from = "wanted.value", per = "40 lpm" }', 0.25),
        ('{ from = "wanted.value", per = { step = ["-20 lpm", "40 lpm"], at = "10 ms" } }', 0.25),
        ('{ from = "wanted.value", per = { value = "1 l/s", status = "assumed", note = "twice 30 lpm" } }', 1.0 / 6.0),
        ('{ from = "supply.pressure", per = "400 bar" }', 101.01325 / 400.0),
        ('{ from = "wanted.value", per = "-40 lpm" }', 0.0),
    ],
)
def test_an_opening_follows_the_share(share, opening):
    """10 of 40 lpm open a valve by 0.25, 10 of 60 by 0.1667, 100 bar and the atmosphere of 400 bar by 0.2525; a
    negative command closes it. The lag of 5 ms leaves e^-20 after 0.1 s."""
    system = built(share)
    run = simulate(system.model, system.case, system.stepping)
    assert run.state.valve.opening[-1] == pytest.approx(opening, rel=1e-6, abs=1e-9)


def test_a_value_has_its_origin():
    row = next(each for each in built('{ from = "wanted.value", per = { value = "40 lpm", status = "assumed" } }').rows
               if each.key == "per")  # fmt: skip
    assert (row.table, row.status) == ("components.valve.command", "assumed")
    assert row.nominal == pytest.approx(40.0 / 6e4)


@pytest.mark.parametrize(
    ("share", "words"),
    [
        ('{ from = "wanted.value", per = "40 bar" }', "'wanted.value' in m.3/s per Pa gives no"),
        ('{ from = "wanted.value", per = "0 lpm" }', "must not be 0"),
        ('{ from = "wanted.value", per = "much" }', "per"),
        (
            '{ from = "wanted.value", per = { ramp = ["-10 lpm", "40 lpm"], from = "1 s", to = "2 s" } }',
            "per = −10 to 40 lpm; must not pass through 0",
        ),
        (
            '{ from = "wanted.value", per = { sine = "30 lpm", amplitude = "40 lpm", frequency = "1 Hz" } }',
            "per = −10 to 70 lpm; must not pass through 0",
        ),
        ('{ from = "wanted.rate", per = "40 lpm" }', "'wanted' has no 'rate'"),
        ('{ from = "nothing.value", per = "40 lpm" }', "leads nowhere"),
    ],
)
def test_a_share_that_is_none_is_refused_at_its_line(share, words):
    with pytest.raises(ConfigError, match=words) as refused:
        built(share)
    (fault,) = refused.value.faults
    assert fault.line == 11 and fault.key.startswith("components.valve.command")
