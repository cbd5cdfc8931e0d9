"""One position loop, and one law of the meter-out throttle, for all circuits that have this throttle."""

import numpy as np
import pytest

from vvdp.control.reference import Reference, ReferenceFilter
from vvdp.machines.duties import shipped_duties
from vvdp.programs.machine.checks import machine_loop_of
from vvdp.programs.machine.common_loop import CommonLoop, asked_of
from vvdp.programs.machine.loop import MachineLoop
from vvdp.programs.position_loop import Joint, LoopMemory, OneWay, PositionLaw, Pressures, one_way_actuation
from vvdp.rivals.rival_account import COMMON_RATE, SAMPLE, common_reference, system_for
from vvdp.rivals.rival_circuits import CIRCUITS, RETURN

HEAVY = next(each for each in shipped_duties() if each.name == "heavy")
METERED = [each for each in CIRCUITS if RETURN in each.sinks]
"""The circuits with a meter-out throttle."""
PUBLISHED = "vvdp-chapter-6"
"""The one that has the source's law."""
SAME = ("table", "position_gain", "area_a", "area_b", "reference_pressure", "valve_conductance")


def settings_of(circuit):
    return system_for(circuit, HEAVY).circuit.network.programs[circuit.program].settings


def law_of(circuit):
    """What the position loop of a circuit knows of its plant."""
    settings = settings_of(circuit)
    return settings.law if isinstance(settings, CommonLoop) else getattr(settings, "loop", settings)


def test_the_law_of_the_meter_out_throttle_is_that_of_all_rows():
    """K = b/(2 m) = 10 1/s, 6 bar, 0.8, 3e-7 m^3/(s Pa^0.5): the same in every row but that of the source's law."""
    laws = {each.name: law_of(each) for each in METERED if each.name != PUBLISHED}
    assert {"vvdp", "vvdp-slow", "vvdp-following", "load-sensing", "ideal-pump", "linear-valves"} < laws.keys()
    assert all(isinstance(each, PositionLaw) for each in laws.values())
    first = laws["vvdp"]
    assert (first.position_gain, first.table.supply_level, first.table.largest_opening) == (10.0, 6e5, 0.8)
    assert first.valve_conductance == 3e-7
    for name, law in laws.items():
        assert [getattr(law, key) for key in SAME] == [getattr(first, key) for key in SAME], name
    published = next(each for each in METERED if each.name == PUBLISHED)
    assert isinstance(settings_of(published), MachineLoop)


def test_a_position_loop_asks_for_flow_side_and_opening():
    """0.1 m/s back and 1 cm too far: v = -0.1 - 10 0.01 = -0.2 m/s, Q = 10.77 cm^2 0.2 = 2.154e-4 m^3/s.

    12 kN on the rod: P_r = (6 bar 10.77 + 12 kN)/20.26 cm^2 = 62.42 bar, u = 20.26 cm^2 0.2/(3e-7 root P_r) = 0.5406.
    """
    law = law_of(next(each for each in CIRCUITS if each.name == "vvdp"))
    level, a, b = law.reference_pressure, 20.26e-4, 10.77e-4
    pressures = Pressures(level + (12e3 + 10e5 * b) / a, level + 10e5, level)
    memory = LoopMemory(Reference(0.10, -0.1, 0.0, 0.0), pressures, Joint(1.0, 1.0))
    found = one_way_actuation(memory, 0.11, law)
    assert found == pytest.approx((-1.0, 2.154e-4, 0.5406), rel=2e-4)
    demand = asked_of(found)
    assert (demand.direction, demand.flow, demand.opening) == tuple(found) and isinstance(found, OneWay)


def test_all_circuits_are_told_the_common_reference_as_shipped():
    drawn = {law_of(each).reference for each in CIRCUITS if each.begin is None}
    led = {machine_loop_of(settings_of(each)).reference for each in CIRCUITS if each.begin is not None}
    assert drawn == led == {ReferenceFilter(filter_rate=COMMON_RATE)}
    assert all(law_of(each).table.sample_period == SAMPLE for each in METERED if each.name != PUBLISHED)


def test_the_common_reference_is_a_ramp_behind_four_poles():
    """At t = 0.8 s, 20 time constants in, 172.8 mm/s lag by 4/25 s: 50 + 172.8 (0.8 - 0.16) = 160.6 mm."""
    late, first = common_reference(HEAVY.cycle, np.array([0.8])), common_reference(HEAVY.cycle, np.array([-1.0, 0.0]))
    assert late == pytest.approx([0.1606], abs=2e-4)
    assert first == pytest.approx([0.05, 0.05], abs=1e-12)
