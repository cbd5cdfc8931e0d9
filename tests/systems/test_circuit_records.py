"""A circuit whose tables are the fields of one dataclass: read, optional, and refused as with an argument for each."""

import pytest

from vvdp.base.errors import ConfigError
from vvdp.systems.circuits import table_slots
from vvdp.systems.system import load_system

MODULE = """
from dataclasses import dataclass
from vvdp.base.kinds import Pressure
from vvdp.base.params import Params
from vvdp.components.library import UsualOil
from vvdp.components.resistances import ORIFICE
from vvdp.hydraulics.orifice import Orifice
from vvdp.network.network import Network
from vvdp.network.nodes import Chamber

class Start(Params):
    pressure: Pressure

@dataclass(frozen=True, kw_only=True)
class Drain:
    tank: Chamber
    start: Start
    outlet: {outlet} = None

def drain(tables: Drain) -> Network:
    net = Network(UsualOil())
    net.volume("line", tables.tank, start=tables.start.pressure)
    net.tank("outside")
    net.add("seep", ORIFICE, Orifice(), a="line", b="outside", area=1e-7)
    if tables.outlet is not None:
        net.add("outlet", ORIFICE, tables.outlet, a="line", b="outside", area=1e-6)
    return net
"""
FILE = """
circuit = "drained:drain"
[tank]
volume = "1 l"
[start]
pressure = "50 bar"
[run]
until = "0.1 s"
"""
OUTLET = """
[outlet]
discharge_coefficient = "0.6"
transition_pressure = "0.1 bar"
"""


def loaded(folder, text, outlet="Orifice | None"):
    (folder / "drained.py").write_text(MODULE.format(outlet=outlet))
    (folder / "file.toml").write_text(text)
    return load_system(str(folder / "file.toml"))


def test_fields_are_tables_and_one_with_a_default_may_be_left_out(tmp_path):
    system = loaded(tmp_path, FILE)
    assert {*system.circuit.network.parts} == {"seep"}
    assert system.tables["tank"].volume == pytest.approx(1e-3)
    slots = table_slots(system.function)
    assert [*slots] == ["tank", "start", "outlet"] and slots["outlet"].optional
    again = loaded(tmp_path, FILE.replace("1 l", "2 l"))
    assert again.circuit.network.nodes["line"].values.volume == pytest.approx(2e-3)


def test_one_that_is_given_is_used(tmp_path):
    assert {*loaded(tmp_path, FILE + OUTLET).circuit.network.parts} == {"seep", "outlet"}


@pytest.mark.parametrize(
    ("text", "outlet", "words"),
    [
        (FILE.replace("[tank]", "[tnk]"), "Orifice | None", "tank: missing table"),
        (FILE + "[gate]\nwidth = 1\n", "Orifice | None", "gate"),
        (FILE, "float", "the table 'outlet' is annotated as <class 'float'>"),
    ],
)
def test_what_is_refused(tmp_path, text, outlet, words):
    with pytest.raises(ConfigError) as told:
        loaded(tmp_path, text, outlet)
    assert words in str(told.value)
