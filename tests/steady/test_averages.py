"""Averages that were found once are read, until anything that they depend on changes."""

from dataclasses import replace

import numpy as np
import pytest

from vvdp.steady import averages as module
from vvdp.steady import cycle_means
from vvdp.steady.averages import averages


def test_second_call_reads_what_the_first_found(source_stand, tmp_path, monkeypatch):
    monkeypatch.setenv("VVDP_CACHE", str(tmp_path))
    valve, here = source_stand.bench.valve, source_stand.set_point
    rows = np.array([source_stand.cycle_point(here._replace(duty_ratio=duty)) for duty in (-0.1, 0.2, 0.5, 1.1)])
    first = averages(rows, valve)

    class Ran(Exception):
        pass

    def runs(*args, **kwargs):
        raise Ran

    monkeypatch.setattr(module, "Replay", runs)
    np.testing.assert_array_equal(first, averages(rows, valve))
    with pytest.raises(Ran):
        averages(rows[1:], valve)
    with pytest.raises(Ran):
        averages(rows, replace(valve, lap_ratio=1.01))
    with monkeypatch.context() as changed, pytest.raises(Ran):
        changed.setattr(cycle_means, "ANGLES", 499)
        averages(rows, valve)
