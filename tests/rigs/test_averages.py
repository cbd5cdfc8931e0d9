"""The compiled flow map against the averages over whole arrays of angles, and what its keeping depends on."""

from dataclasses import replace

import numpy as np
import pytest

from vvdp.rigs import averages
from vvdp.rigs.averages import flow_map
from vvdp.valve.condition import Condition
from vvdp.valve.flow_map import quasi_steady_mean

TANK, RELIEF, FLOW, RHO = 101325.0, 121.01325e5, 40e-3 / 60.0, 876.0
DUTIES, LOADS = (-0.1, 0.03, 0.2, 0.5, 0.97, 1.1), (1.2e5, 60e5, 118e5, 130e5)


@pytest.mark.parametrize("override", [0.0, 5e5, 60e5])
@pytest.mark.parametrize("lap", [0.6, 1.0, 1.3])
def test_same_as_over_whole_arrays(source_stand, override, lap):
    """Both find the flow at each angle to 1e-12 of the pump's at worst; a difference of 1e-10 would be an error."""
    valve = source_stand.changed(valve={"lap_ratio": lap}).bench.valve
    rest = (RELIEF, override, TANK, FLOW, RHO, valve)
    found = flow_map(DUTIES, LOADS, *rest)
    for row, load in enumerate(LOADS):
        for column, duty in enumerate(DUTIES):
            at = Condition(flow=FLOW, load_pressure=load, relief_pressure=RELIEF, tank_pressure=TANK, density=RHO)
            known = quasi_steady_mean(duty, at, valve, override)
            one = [values[row, column] for values in found]
            scales = (FLOW, FLOW, FLOW, known.inlet_pressure, FLOW * RELIEF)
            for value, expected, scale in zip(one, known, scales, strict=True):
                assert value == pytest.approx(expected, rel=0.0, abs=1e-10 * scale), (duty, load)


def test_second_call_reads_what_the_first_found(source_stand, tmp_path, monkeypatch):
    valve = source_stand.bench.valve
    rest = (RELIEF, 0.0, TANK, FLOW, RHO)
    first = flow_map(DUTIES, LOADS, *rest, valve, cache=tmp_path)

    class Ran(Exception):
        pass

    def runs(*args, **kwargs):
        raise Ran

    monkeypatch.setattr(averages, "Replay", runs)
    np.testing.assert_array_equal(np.array(first), np.array(flow_map(DUTIES, LOADS, *rest, valve, cache=tmp_path)))
    with pytest.raises(Ran):
        flow_map((*DUTIES[:-1], 1.2), LOADS, *rest, valve, cache=tmp_path)
    with pytest.raises(Ran):
        flow_map(DUTIES, LOADS, *rest, replace(valve, lap_ratio=1.01), cache=tmp_path)
    with monkeypatch.context() as changed, pytest.raises(Ran):
        changed.setattr(averages, "ANGLES", 999)
        flow_map(DUTIES, LOADS, *rest, valve, cache=tmp_path)
