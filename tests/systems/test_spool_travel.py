"""The axial travel of a spool: what its drive gives, helix needs and solids allow, and how a run says so."""

from collections import defaultdict
from dataclasses import replace

import numpy as np
import pytest
from tests.words import wording

from vvdp.base.errors import ConfigError
from vvdp.base.tables import Table, parsed_table
from vvdp.components.rods import END_STOP
from vvdp.components.rotary_valve import ROTARY_VALVE
from vvdp.evaluation.bench_report import additions
from vvdp.fluid.oil import Oil
from vvdp.geometry.shape import Travel
from vvdp.geometry.shape_tables import given_shape
from vvdp.hydraulics.check_valve import CheckPoppet
from vvdp.hydraulics.rod import EndStop
from vvdp.network.network import Network
from vvdp.network.nodes import Load
from vvdp.systems.resolved import resolved_text
from vvdp.systems.spool_travel import (
    duty_travel,
    first_position,
    helix_conflicts,
    prescribed_travel,
    solid_conflicts,
    stop_travel,
    travel_warnings,
)
from vvdp.systems.system import System, built_system, load_system, system_table
from vvdp.valve.geometry import port_openings
from vvdp.valve.rotary import RotaryValve

WIDE = ("geometry.stroke_ratio=1.66",)


def moved_spool(oil: Oil, valve: RotaryValve, check_valve: CheckPoppet, rod: Load, stop: EndStop) -> Network:
    """A rotary valve between three sources whose spool lies on a rod with end stops."""
    net = Network(oil)
    for name, pressure in (("inlet", 6e6), ("load_line", 5e6), ("tank", 1e5)):
        net.pressure_source(name, pressure)
    net.driven_shaft("spool", 150.0)
    net.rod("axial", rod, position=-6.2e-3)
    net.add("stop", END_STOP, stop, rod="axial")
    net.add("valve", ROTARY_VALVE, valve, check_valve, inlet="inlet", load="load_line", tank="tank", spool="spool",
            axial_position="axial.position", cavitation_pressure=3e4)  # fmt: skip
    return net


def moved(low: str, high: str, **geometry: str) -> System:
    """The system of `moved_spool` with end stops at two positions."""
    shipped = system_table("prototype").content
    content = {
        "circuit": f"{__name__}:moved_spool",
        **{name: shipped[name] for name in ("oil", "valve", "check_valve")},
        "rod": {"mass": "0.5 kg"},
        "stop": {"lower_end": low, "upper_end": high, "stop_stiffness": "1e6 N/m", "stop_damping": "1 s/m"},
        "run": {"until": "1 ms", "average_from": "0 s"},
    }
    return built_system(Table("moved", content | ({"geometry": geometry} if geometry else {}), {}), "moved")


@pytest.fixture(scope="module")
def valve() -> RotaryValve:
    return load_system("prototype").case.params.valve


def test_travel_of_the_duty_ratio_by_hand(valve):
    """kappa = 2 x 3.9908/26.599 = 0.30007: 6.097 mm below, 26.417 mm above."""
    assert duty_travel(valve) == pytest.approx((-6.0975e-3, 26.4175e-3), abs=2e-7)


@pytest.mark.parametrize(("end", "port"), [(0, "tank"), (1, "load")])
def test_a_port_just_stays_open_at_the_end_of_the_travel(valve, end, port):
    """The whole flow goes to one port there at every angle; a millimetre short it does not."""
    at, inwards = duty_travel(valve)[end], 1e-3 * (1 - 2 * end)
    angles = np.linspace(0.0, 2.0 * np.pi / 3.0, 721)
    least = [min(getattr(port_openings(a, x, valve), port) for a in angles) for x in (at, at + inwards)]
    assert least[0] == pytest.approx(1.0, abs=1e-9)
    assert least[1] < 0.999


def test_end_stops_that_reach_both_duty_ratios_are_no_conflict(valve):
    assert list(helix_conflicts(Travel(-6.2e-3, 26.4e-3), valve)) == []
    assert list(helix_conflicts(Travel(-6.2e-3, 27e-3), valve)) == []


def test_end_stops_short_of_a_duty_ratio_are_told_with_numbers(valve):
    low, high = helix_conflicts(Travel(0.0, 6.34e-3), valve)
    assert low == wording.systems.spool_stops.format(
        stop="0 mm", duty=0, position="−6.097 mm"
    ) + wording.systems.of_helix.format(kappa="0.300", helix="20.32 mm")
    assert high.startswith(wording.systems.spool_stops.format(stop="6.34 mm", duty=1, position="26.42 mm"))


def test_solids_in_the_way_are_told_with_what_they_take(valve):
    shape = given_shape(valve, None, ()).shape
    low, high = solid_conflicts(Travel(-6.2e-3, 26.4e-3), valve, shape)
    assert low.startswith(
        wording.systems.goes_down.format(position="−6.2 mm", end="0 mm")
        + wording.systems.stroke_ratio_is.format(ratio="1.00")
    )
    assert high.startswith(wording.systems.goes_up.format(position="26.4 mm", end="20.32 mm"))
    # 2 (1/2 + 6.2/20.32) = 1.6102
    assert low.endswith(wording.systems.takes_ratio.format(ratio=1.62))
    assert list(solid_conflicts(Travel(-6.2e-3, 26.4e-3), valve, replace(shape, stroke_ratio=1.62))) == []
    assert len(list(solid_conflicts(Travel(-6.2e-3, 26.4e-3), valve, replace(shape, stroke_ratio=1.6)))) == 1


@pytest.mark.parametrize("name", ["prototype", "prototype-constant-load"])
def test_shipped_benches_are_told_nothing_new(name):
    assert list(travel_warnings(load_system(name))) == []
    assert load_system(name).shape is None


def test_a_prescribed_position_is_held_against_the_solids_of_the_file():
    outside = ("operation.axial_position=-6.1 mm",)
    assert list(travel_warnings(load_system("prototype", outside))) == []  # the file says nothing of solids
    (told,) = travel_warnings(load_system("prototype", (*outside, "geometry.stroke_ratio=1")))
    assert told.startswith(wording.systems.goes_down.format(position="\u22126.1 mm", end="0 mm"))
    assert list(travel_warnings(load_system("prototype", (*outside, *WIDE)))) == []


def test_solids_that_cannot_be_made_are_told_not_refused():
    (told,) = travel_warnings(load_system("prototype", ("geometry.rail_radius=18 mm",)))
    assert told.startswith(wording.systems.no_solid.format(radius=12.8))


def test_the_duty_ratio_of_a_bench_is_a_position():
    system = load_system("prototype", ('operation.duty_ratio={ramp=["0.2", "0.6"], from="0.1 s", to="0.2 s"}',))
    assert prescribed_travel(system.circuit.network) == pytest.approx((0.2 * 20.32e-3, 0.6 * 20.32e-3))
    assert first_position(system) == pytest.approx(0.2 * 20.32e-3)


def test_end_stops_on_the_rod_of_the_spool_are_its_travel():
    system = moved("-6.2 mm", "26.4 mm", stroke_ratio="1.66")
    assert stop_travel(system.circuit.network) == pytest.approx((-6.2e-3, 26.4e-3))
    assert prescribed_travel(system.circuit.network) is None
    assert first_position(system) == pytest.approx(-6.2e-3)
    assert list(travel_warnings(system)) == []


def test_a_start_beyond_the_stops_is_told():
    """Of both drives; a hundredth of a millimetre beyond the stop, where the spring presses it in, is none."""
    for name in ("displacement-control", "displacement-control-gerotor"):
        told = [*travel_warnings(load_system(name, ["initial.axial_position=30 mm"]))]
        assert told == ["the spool starts at 30 mm, it goes from −6.2 mm to 27 mm"]
        assert [*travel_warnings(load_system(name, ["initial.axial_position=-6.21 mm"]))] == []


def test_drive_helix_and_solids_that_disagree_are_all_told():
    told = list(travel_warnings(moved("-6.2 mm", "20 mm", stroke_ratio="1")))
    assert len(told) == 2
    assert wording.systems.needs_position.format(duty=1, position="26.42 mm") in told[0]
    assert wording.systems.goes_down.format(position="−6.2 mm", end="0 mm") in told[1]


@pytest.mark.parametrize("name", ["axial-chamber", "axial-gerotor"])
def test_the_shipped_drives_fit_the_helix_and_the_shipped_full_stroke(name, valve):
    """End stops on the rod, or in the drive itself: -6.2 to 27 mm, within -6.71 to 27.03 mm."""
    stops = stop_travel(load_system(name).circuit.network)
    assert stops == pytest.approx((-6.2e-3, 27e-3))
    assert list(helix_conflicts(stops, valve)) == []
    assert list(solid_conflicts(stops, valve, given_shape(valve, "full-stroke", ()).shape)) == []


FILE = """
[geometry]
stroke_ratio = { value = "1.66", status = "derived", note = "room for both ends" }
pocket_gap = "1.6 mm"
"""


def test_a_system_file_carries_its_shape_and_so_does_what_is_written():
    text = resolved_text(load_system("prototype")) + FILE
    system = built_system(parsed_table(text, "mine.toml"), "mine")
    assert system.shape is not None
    assert (system.shape.stroke_ratio, system.shape.pocket_gap) == (1.66, pytest.approx(1.6e-3))
    assert {row.setting: row.status for row in system.rows if row.table == "geometry"} == {
        "geometry.stroke_ratio": "derived",
        "geometry.pocket_gap": "given",
    }
    written = resolved_text(system)
    assert 'stroke_ratio = { value = "1.66", status = "derived", note = "room for both ends" }' in written
    assert built_system(parsed_table(written, "again.toml"), "again").shape == system.shape


def test_the_solids_are_in_no_law(valve):
    """What a file says of the valve as a solid leaves the case that is simulated as it is."""
    plain, wide = load_system("prototype"), load_system("prototype", WIDE)
    assert wide.case.params == plain.case.params
    assert wide.circuit.text == plain.circuit.text


def test_faults_of_the_shape_have_their_line():
    text = resolved_text(load_system("prototype")) + FILE.replace("pocket_gap", "pocket_gp")
    with pytest.raises(
        ConfigError, match="geometry.pocket_gp: " + wording.files.unknown_key.format(meant="pocket_gap")
    ) as refused:
        built_system(parsed_table(text, "mine.toml"), "mine")
    assert refused.value.faults[0].line == text[: text.index("pocket_gp")].count("\n") + 1


def test_a_shape_without_a_valve_is_refused():
    with pytest.raises(ConfigError, match=wording.systems.rotary_valves.format(count=0)):
        load_system("long-hose", WIDE)


@pytest.mark.parametrize(("position", "kept"), [("-6.2 mm", True), ("27 mm", True), ("-8 mm", False), ("28 mm", False)])
def test_a_spool_at_its_stops_is_within_the_laws_of_the_valve(position, kept):
    """-kappa - 0.05 = -0.3501 of 20.32 mm is -7.11 mm, 1.3501 of it 27.43 mm."""
    system = load_system("prototype", (f"operation.axial_position={position}",))
    (duty,) = [each for each in additions(system).bounds(_numbers()) if each.label == "duty ratio"]
    assert duty.is_kept is kept


def _numbers() -> dict[str, float]:
    """Numbers of a run that the bounds of a bench ask for, none of them unusual."""
    return defaultdict(lambda: 1.0)
