"""The operating point of a design study in words."""

from vvdp.base.display import number, with_unit
from vvdp.base.kinds import FLOW, POWER, PRESSURE_LEVEL, TEMPERATURE
from vvdp.design.quantities import Setup, setup
from vvdp.evaluation.bench import rotary_bench
from vvdp.systems.system import System

LEFT_OUT = (
    "The ripple behind the load port: analytic values take load and relief pressure as steady.",
    "Lag and override of the relief valve, which analytic values take as ideal.",
    "Vapour: no flow law saturates, also where a port cavitates.",
)


def sentence(text: str) -> str:
    """Words as a sentence: with a capital and a full stop."""
    return f"{text[:1].upper()}{text[1:]}."


def conditions(system: System) -> dict[str, str]:
    """Pump flow, oil, duty ratio, load, relief setting and motor at the start of a run, as a reader wants them."""
    at: Setup = setup(system)
    return {
        "system": system.title,
        "pump flow": with_unit(at.flow, FLOW),
        "oil": with_unit(at.temperature, TEMPERATURE),
        "duty ratio": number(at.duty_ratio, 3),
        "load": with_unit(at.load_pressure, PRESSURE_LEVEL),
        "relief setting": with_unit(at.relief_pressure, PRESSURE_LEVEL),
        "tank": with_unit(at.tank_pressure, PRESSURE_LEVEL),
        "motor": with_unit(rotary_bench(system, "design").rated_power, POWER),
    }
