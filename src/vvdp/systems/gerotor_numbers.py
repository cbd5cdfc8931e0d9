"""How well a gerotor drive is controlled: errors of position and estimate, and their pictures."""

from typing import TYPE_CHECKING

from vvdp.programs.axial_loop import PROGRAM
from vvdp.programs.gerotor_loop import GerotorLoop, WatchedGerotor
from vvdp.systems.axial_numbers import spool_numbers
from vvdp.systems.extras import LoadedSystem, Summary

if TYPE_CHECKING:
    from vvdp.simulation.run import Run


def gerotor_numbers(run: "Run", system: LoadedSystem, helix_length: float) -> Summary:
    """How well the drive of a system was controlled; `helix_length` [m]."""
    settings = system.circuit.network.programs[PROGRAM].settings
    loop = settings.loop if isinstance(settings, WatchedGerotor) else settings
    assert isinstance(loop, GerotorLoop)
    return spool_numbers(run, run.state.gerotor.position, loop.sample_period, helix_length)
