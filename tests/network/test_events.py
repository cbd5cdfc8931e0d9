"""Events of components in whole runs, against closed forms."""

import numpy as np
import pytest

from vvdp.base.signal import sine
from vvdp.components.flow_sources import FLOW_SOURCE
from vvdp.components.library import UsualOil
from vvdp.components.self_acting_valves import RELIEF_VALVE
from vvdp.fluid.mixture import fluid_state
from vvdp.hydraulics.flow_source import FlowSource
from vvdp.hydraulics.relief_valve import ReliefValve
from vvdp.network.build import build
from vvdp.network.network import Network
from vvdp.network.nodes import Chamber
from vvdp.simulation.run import Method, Stepping, simulate

FLOW, OMEGA, VOLUME, CRACKING, START = 4e-4, 50.0, 1e-4, 1e7, 1e6


def limited(oil: UsualOil, override: float = 0.0):
    """A chamber that q_0 cos(omega t) fills, counted in tank volumes, and a relief valve over it."""
    net = Network(oil)
    net.tank("tank")
    net.volume("chamber", Chamber(volume=VOLUME), start=START)
    flow = sine(0.0, FLOW, OMEGA / (2.0 * np.pi), 0.5 * np.pi)
    net.add("supply", FLOW_SOURCE, FlowSource(counted_at_outlet=0.0), a="tank", b="chamber", flow=flow)
    values = ReliefValve(cracking_pressure=CRACKING, override_pressure=override, rated_flow=6e-4)
    net.add("relief", RELIEF_VALVE, values, a="chamber", b="tank")
    return build(net)


def content(pressure: float, oil: UsualOil) -> float:
    """What the chamber holds, in tank volumes."""
    return VOLUME / fluid_state(pressure, oil).volume_ratio


@pytest.mark.parametrize("method", [Method.EXPLICIT, Method.AUTOMATIC])
@pytest.mark.parametrize("tolerance", [1e-4, 1e-6, 1e-9])
def test_an_ideal_relief_valve_takes_what_the_chamber_cannot(method, tolerance):
    """It opens when the chamber holds what it holds at the cracking pressure, and shuts as the flow turns round.

    In tank volumes nothing is left to the integration of the pressure: of q_0/omega up to then all goes over the valve
    but what the chamber has taken, and then the chamber gives back.
    """
    oil = UsualOil()
    circuit, quarter = limited(oil), 0.5 * np.pi / OMEGA
    until = 1.3 * quarter
    run = simulate(circuit.model, circuit.case, Stepping(until=until, relative_tolerance=tolerance, method=method))
    taken = content(CRACKING, oil) - content(START, oil)
    over = FLOW / OMEGA - taken
    assert over > 0.2 * FLOW / OMEGA
    # The pressure at which it opens is off by at most the tolerance of the run, and so is what is in the chamber.
    accuracy = 10.0 * tolerance * taken + 1e-9 * over
    assert run.final_state.books.totals.relief_flow == pytest.approx(over, rel=0.0, abs=accuracy)
    left = content(CRACKING, oil) - FLOW / OMEGA * (1.0 - np.sin(OMEGA * until))
    assert content(run.final_state.chamber, oil) == pytest.approx(left, rel=10.0 * tolerance + 1e-9)
    assert run.high[0] == pytest.approx(CRACKING, rel=10.0 * tolerance)


def test_its_mode_is_recorded():
    circuit = limited(UsualOil())
    run = simulate(circuit.model, circuit.case, Stepping(until=0.04, window_interval=1e-4))
    opened = run.times[1:][np.diff(run.command.modes.relief_side) > 0.5]
    shut = run.times[1:][np.diff(run.command.modes.relief_side) < -0.5]
    assert opened.size == shut.size == 1
    assert shut[0] == pytest.approx(0.5 * np.pi / OMEGA, abs=1.1e-4)
    flow = run.outputs.relief_flow
    assert np.all(flow[run.command.modes.relief_side == 0.0] == 0.0)
