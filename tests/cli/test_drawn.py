"""A circuit that a file draws, and one from a module of one's own: from the file to the page, and what may go wrong."""

import json

import pytest
from tests.words import wording

from vvdp.components.library import COMPONENTS
from vvdp.programs.library import PROGRAMS
from vvdp.simulation.results import read_results
from vvdp.systems.drawing import NODES

DRAWN = """\
title = "Pump and throttle"

[nodes]
tank = { type = "tank" }
rail = { type = "volume", volume = { value = "100 cc", status = "assumed", note = "hose" }, start = "20 bar" }
store = { type = "vessel", oil_volume = "0.1 l", gas_volume = "50 cc", precharge_pressure = "10 bar", start = "20 bar" }
shaft = { type = "driven-shaft", speed = "1500 rpm" }

[components.pump]
type = "pump"
inlet = "tank"
outlet = "rail"
shaft = "shaft"
displacement = { value = "10 cc/rev", status = "published", source = "merritt1967" }
leakage_conductance = "1e-12 m^3/(s*Pa)"
ripple_amplitude = "0"
ripple_count = "9"
friction_torque = "1 N*m"

[components.feed]
type = "orifice"
a = "rail"
b = "store"
area = "5 mm^2"
discharge_coefficient = "0.61"
transition_pressure = "0.05 bar"

[components.load]
type = "orifice"
a = "store"
b = "tank"
area = { step = ["3 mm^2", "4 mm^2"], at = "20 ms" }
discharge_coefficient = "0.61"
transition_pressure = "0.05 bar"

[run]
until = "60 ms"
window = "20 ms"
"""

MODULE = '''\
"""A pump against an orifice."""

from vvdp.base.kinds import DURATION, PRESSURE_LEVEL, SIGNED_PRESSURE, AreaSignal, Pressure, SpeedSignal
from vvdp.base.params import Params
from vvdp.components.machines import PUMP
from vvdp.components.resistances import ORIFICE
from vvdp.fluid.oil import Oil
from vvdp.components.library import UsualOil
from vvdp.hydraulics.orifice import Orifice
from vvdp.hydraulics.pump import Pump
from vvdp.network.network import Network
from vvdp.network.nodes import Chamber
from vvdp.results.chart import Chart, Lines
from vvdp.results.chart import Line as Curve
from vvdp.results.result import Column, Table
from vvdp.systems.extras import Extras, Line


class Load(Orifice):
    """The load."""

    area: AreaSignal


class Operation(Params):
    """What is prescribed."""

    speed: SpeedSignal
    start: Pressure


class Peak(Extras):
    """How far the pressure overshoots."""

    OVERVIEW = (Line("overshoot", ("overshoot_Pa",), SIGNED_PRESSURE),)

    def simulation_numbers(self, run, found):
        return {"overshoot_Pa": found["pressure_max_rail_Pa"] - found["pressure_mean_rail_Pa"]}

    def warnings(self, found):
        yield "this is only an example"

    def charts(self, record):
        columns = {
            "time_s": Column(record.times, DURATION, "time"),
            "rail_Pa": Column(record.states["rail"].values, PRESSURE_LEVEL, "rail"),
        }
        panel = Lines(lines=(Curve(x="time_s", y="rail_Pa"),))
        chart = Chart(name="own", caption="Our own figure.", table="rail", panels=(panel,), height=2.0)
        yield chart, Table(title="Rail", columns=columns)


def network(pump: Pump, rail: Chamber, load: Load, operation: Operation) -> Network:
    """A pump against an orifice."""
    net = Network(UsualOil(), operation=operation, load=load)
    net.tank("tank")
    net.volume("rail", rail, start="operation.start")
    net.driven_shaft("shaft", operation.speed)
    net.add("pump", PUMP, pump, inlet="tank", outlet="rail", shaft="shaft")
    net.add("load", ORIFICE, load, a="rail", b="tank", area=load.area)
    net.extras = Peak
    return net
'''

OWN = """\
title = "Mine"
circuit = "my_pump:network"

[pump]
displacement = "10 cc/rev"
leakage_conductance = "1e-12 m^3/(s*Pa)"
ripple_amplitude = "0"
ripple_count = "9"
friction_torque = "1 N*m"

[rail]
volume = "100 cc"

[load]
area = "5 mm^2"
discharge_coefficient = "0.61"
transition_pressure = "0.05 bar"

[operation]
speed = "1500 rpm"
start = "20 bar"

[run]
until = "50 ms"
window = "20 ms"
"""


@pytest.fixture
def drawn(here):
    (here / "press.toml").write_text(DRAWN)
    return here


@pytest.fixture
def own(here):
    (here / "mine.toml").write_text(OWN)
    (here / "my_pump.py").write_text(MODULE)
    return here


def test_a_drawn_circuit_from_file_to_page(vvdp, drawn):
    answer = vvdp("run", "press.toml", "--out", "out")
    assert answer.code == 0, answer.err
    for words in (
        "Pump and throttle",
        "rail",
        "store",
        wording.run.power_in,
        wording.run.of_which_leakage,
        "balances: energy",
    ):
        assert words in answer.out
    assert "PWM" not in answer.out and wording.run.closed_form not in answer.out
    page = (drawn / "out" / "report.html").read_text("utf-8")
    for words in (
        "Pump and throttle",
        wording.report.drawn.format(nodes=4, components=3),
        "def circuit(t, s, u, p):",
        "merritt1967",
    ):
        assert words in page
    assert "PWM" not in page
    assert {p.stem for p in (drawn / "out" / "figures").glob("*.svg")} == {
        "circuit",
        "detail",
        "run",
        "losses-component",
    }
    again = vvdp("report", "out")
    assert again.code == 0
    assert (drawn / "out" / "report.html").read_text("utf-8") == page
    resolved = json.loads(vvdp("run", "out/system.toml", "--no-report", "--json", "--out", "again").out)
    key = "pressure_mean_rail_Pa"
    assert resolved[key] == read_results(drawn / "out").summary[key]


def test_the_keys_of_any_circuit(vvdp, drawn):
    found = json.loads(vvdp("run", "press.toml", "--no-report", "--json", "--out", "out").out)
    general = {
        "energy_residual",
        "mass_residual",
        "trusted",
        "second_law",
        "within_validity",
        "cavitation_volume",
        "stored_power_W",
        "finished",
        "settled",
    }
    general |= {f"pressure_{which}_{node}_Pa" for which in ("mean", "min", "max") for node in ("tank", "rail", "store")}
    general |= {f"flow_mean_{part}_m3_s" for part in ("pump", "feed", "load", "pump_leakage")}
    general |= {f"loss_{part}_W" for part in ("pump", "pump_leakage", "pump_friction", "feed", "load")}
    general |= {"power_tank_W", "power_shaft_W"}
    assert general <= found.keys()
    assert found["trusted"] and abs(found["energy_residual"]) < 1e-6 and abs(found["mass_residual"]) < 1e-6
    assert found["pressure_min_store_Pa"] <= found["pressure_mean_store_Pa"] <= found["pressure_max_store_Pa"]
    assert found["loss_pump_W"] == pytest.approx(found["loss_pump_leakage_W"] + found["loss_pump_friction_W"])


def test_show_of_a_drawn_circuit(vvdp, drawn):
    said = vvdp("show", "press.toml").out
    for words in (
        wording.show.driven_shaft,
        "pump.inlet, load.b",
        "a: store, b: tank",
        wording.show.area_range.format(low=3, high=4),
        "[components.pump]",
    ):
        assert words in said
    text = vvdp("show", "press.toml", "--text").out
    assert text.startswith("def circuit(t, s, u, p):\n")
    compile(text, "press", "exec")
    content = json.loads(vvdp("show", "press.toml", "--json").out)
    assert content["parameters"]["components.pump.displacement"]["source"] == "merritt1967"
    assert "nodes.rail.volume" in content["assumed"]
    assert not [key for key in content["assumed"] if key.startswith("run.")]


def test_list_and_new_know_drawn_circuits(vvdp, drawn):
    assert "press.toml" in vvdp("list").out
    assert vvdp("new", "other", "--from", "press.toml").code == 0
    assert (drawn / "other.toml").read_text() == DRAWN.replace("Pump and throttle", "other")


def test_a_component_and_a_part_of_one_name_are_both_shown(vvdp):
    said = vvdp("list", "gerotor-drive").out
    assert said.startswith("gerotor-drive: ")
    assert "believed_largest_flow" in said


def test_the_library_is_listed(vvdp):
    said = vvdp("list", "--components").out
    for name in (*NODES, *COMPONENTS, *PROGRAMS):
        assert name in said.split()
    assert 'displacement = "10 cc/rev"' in said
    assert 'opening = "1" [1]' in said
    assert "rod (rod)" in said and "shaft (shaft)" in said


def test_the_library_as_json(vvdp):
    found = json.loads(vvdp("list", "--components", "--json").out)
    assert {"components", "programs", "parts"} <= found.keys()
    assert found["programs"]["pi"]["reads"] == ["reads", "reference", "feedforward [0]"]
    assert found["programs"]["pi"]["commands"] == ["value"]
    assert 'gain = "-0.01 1/bar"' in found["programs"]["pi"]["values"]


def test_a_circuit_of_ones_own(vvdp, own, monkeypatch):
    monkeypatch.setenv("VVDP_CACHE", str(own / "cache"))
    shown = vvdp("show", "mine.toml")
    assert shown.code == 0, shown.err
    assert wording.network.own_code_runs.format(module="my_pump.py") in shown.err
    assert wording.network.own_code not in vvdp("show", "mine.toml").err
    (own / "my_pump.py").write_text(MODULE + "\n# changed\n")
    assert wording.network.own_code in vvdp("show", "mine.toml").err
    monkeypatch.undo()
    monkeypatch.chdir(own)
    answer = vvdp("run", "mine.toml", "--out", "out")
    assert answer.code == 0, answer.err
    assert "overshoot" in answer.out and "warning: this is only an example" in answer.out
    assert (own / "out" / "figures" / "own.svg").is_file()
    assert "Our own figure." in (own / "out" / "report.html").read_text("utf-8")
    assert "overshoot_Pa" in read_results(own / "out").summary
    (own / "my_pump.py").unlink()
    assert vvdp("report", "out").code == 0
    assert vvdp("run", "out/system.toml", "--no-report", "--out", "again").code == 2  # nothing in there is run
    (own / "copy").mkdir()
    for name in ("system.toml", "my_pump.py"):
        (own / "copy" / name).write_bytes((own / "out" / name).read_bytes())
    assert vvdp("run", "copy/system.toml", "--no-report", "--out", "again").code == 0


def line_of(text: str) -> int:
    assert DRAWN.count(text) == 1
    return DRAWN[: DRAWN.index(text)].count("\n") + 1


FAULTS = {
    "unknown type": (
        'type = "pump"',
        'type = "pmp"',
        "components.pump",
        wording.network.unknown_type.format(name="pmp"),
    ),
    "open port": ('outlet = "rail"\n', "\n", "components.pump", wording.network.port_is_open.format(port="outlet")),
    "unknown node": (
        'a = "rail"',
        'a = "rial"',
        "components.feed",
        wording.network.no_node.format(name="rial", meant="rail"),
    ),
    "wrong node": ('outlet = "rail"', 'outlet = "shaft"', "components.pump", wording.network.joins_volume),
    "wrong unit": (
        'area = "5 mm^2"',
        'area = "5 bar"',
        "components.feed.area",
        wording.files.is_not_a.format(quantity="an area"),
    ),
    "no unit": ('speed = "1500 rpm"', 'speed = "1500"', "nodes.shaft.speed", wording.files.has_no_unit),
    "typo": (
        "displacement =",
        "displacment =",
        "components.pump.displacment",
        wording.files.did_you_mean.format(name="displacement"),
    ),
    "wrong port": ('a = "rail"', 'aa = "rail"', "components.feed.aa", wording.files.unknown_key.format(meant="a")),
    "missing": ('friction_torque = "1 N*m"\n', "\n", "components.pump.friction_torque", wording.network.missing_key),
    "no input": ('area = "5 mm^2"\n', "\n", "components.feed", wording.network.input_not_connected.format(name="area")),
    "node's type": (
        '{ type = "tank" }',
        '{ type = "tnk" }',
        "nodes.tank",
        wording.network.unknown_type.format(name="tnk"),
    ),
    "no start": (
        ', start = "20 bar" }\nstore',
        " }\nstore",
        "nodes.rail.start",
        wording.files.missing_key.format(key="start"),
    ),
}


@pytest.mark.parametrize("fault", FAULTS)
def test_a_mistake_is_one_line_with_its_place(vvdp, drawn, fault):
    old, new, key, said = FAULTS[fault]
    assert DRAWN.count(old) >= 1
    (drawn / "press.toml").write_text(DRAWN.replace(old, new, 1))
    answer = vvdp("run", "press.toml", "--out", "out")
    assert answer.code == 2
    assert not answer.out
    told = [line for line in answer.err.splitlines() if said in line]
    assert len(told) == 1, answer.err
    place, line, _ = told[0].split(":", 2)
    assert place == "press.toml" and int(line) > 0
    assert f" {key}: " in told[0]
    assert not (drawn / "out").exists()


def test_a_name_that_is_mistyped_on_the_command_line_is_told_there(vvdp, drawn):
    answer = vvdp("run", "press.toml", "--set", "components.fed.area=3 mm^2")
    assert answer.code == 2
    assert answer.err.strip() == "--set: components.fed: " + wording.network.has_no_type.format(meant="feed")


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("def network(", "def netwerk(", wording.files.did_you_mean.format(name="netwerk")),
        ("import PUMP", "import PMP", wording.network.cannot_run.format(error="ImportError")),
        ("net.extras = Peak", "net.extras = Pk", wording.network.cannot_draw.format(error="NameError")),
        ('b="tank", area', "area", "load: " + wording.network.port_is_open.format(port="b")),
        ("return net", "return 3", wording.network.returns_no_network),
        ("rail: Chamber", "rail: float", wording.network.annotation.format(table="rail")),
        ('"""A pump', '""A pump', wording.network.cannot_run.format(error="SyntaxError")),
    ],
)
def test_a_mistake_in_a_module_is_one_line(vvdp, own, old, new, said):
    assert old in MODULE
    (own / "my_pump.py").write_text(MODULE.replace(old, new, 1))
    answer = vvdp("show", "mine.toml")
    assert answer.code == 2
    told = [line for line in answer.err.splitlines() if wording.network.own_code not in line]
    assert len(told) == 1, answer.err
    assert told[0].startswith("mine.toml") and said in told[0]
