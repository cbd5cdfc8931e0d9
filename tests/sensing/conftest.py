from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from vvdp.base.signal import constant
from vvdp.sensing.encoder import NO_FAULTS, SAMPLED, Encoder, Shaft, encoder_start, encoder_step
from vvdp.sensing.photodiode import LightSpot
from vvdp.sensing.wheel import equal_wheel
from vvdp.simulation.replay import Replay

STRIP = LightSpot(width=5e-3, track_radius=64e-3 / (2.0 * np.pi), roundness=0.0)


@pytest.fixture(scope="session")
def make_encoder() -> Callable[..., Encoder]:
    """The prototype's encoder without noise, with changes; `faults` as a mapping."""

    def made(faults=None, **changes) -> Encoder:
        plain = Encoder(
            wheel=equal_wheel(8, 0.25),
            spot=STRIP,
            threshold=constant(0.5),
            hysteresis=0.0,
            noise=0.0,
            counter_bits=16.0,
            acquisition=SAMPLED,
            faults=replace(NO_FAULTS, **(faults or {})),
        )
        return replace(plain, **changes)

    return made


class Readings:
    """Columns of the readings at samples with edges."""

    def __init__(self, shown: np.ndarray) -> None:
        self.all = shown
        later = shown[1:]  # over the first interval the speed is known at one end alone
        seen = later[later[:, 1] > 0.0]
        self.time, self.edges, self.edge_time, self.interval, self.polarity = seen.T


@pytest.fixture(scope="session")
def read() -> Callable[..., Readings]:
    """Readings of an encoder over samples at `times` of a shaft with angles and speeds given there."""
    compiled: dict[int, Replay] = {}

    def run(encoder, times, angles, speeds, start=None, seed=1.0) -> Readings:
        begin = (2.0 * times[0] - times[1], 2.0 * angles[0] - angles[1]) if start is None else start
        memory = encoder_start(encoder, *begin, seed)
        edges = len(encoder.wheel.edges)
        if edges not in compiled:
            compiled[edges] = Replay(encoder_step, memory, Shaft(0.0, 0.0, 0.0), encoder)
        rows = np.column_stack([times, angles, np.broadcast_to(speeds, np.shape(times))])
        return Readings(compiled[edges](memory, rows, encoder).shown)

    return run
