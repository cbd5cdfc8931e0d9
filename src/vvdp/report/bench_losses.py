"""The losses of a test bench of the rotary valve, by component and by cause."""

from collections.abc import Iterator
from dataclasses import dataclass

from vvdp.report.reading import Reading

COMPONENTS = {
    "nozzle": "nozzles",
    "centre_section": "centre section",
    "outlet_turbine": "outlet turbine",
    "relief_valve": "relief valve",
    "valve_leakage": "valve leakage",
    "pump_leakage": "pump leakage",
    "pump_friction": "pump friction",
    "coupling": "spool coupling",
}


@dataclass(frozen=True)
class Loss:
    """A mean power lost [W]; `analytic` is nan where there is no formula."""

    name: str
    simulated: float
    analytic: float = float("nan")


def components(reading: Reading) -> Iterator[Loss]:
    """Simulated losses by component. The spool's friction is fed from the valve's drops and not a loss beside them."""
    for key, name in COMPONENTS.items():
        yield Loss(name, reading.number(f"loss_{key}_W"))


def spool_balance(reading: Reading) -> Loss:
    """What the spool's friction turns to heat beyond what the flow gives to the spool."""
    return Loss(
        "spool friction beyond its drive",
        reading.number("loss_spool_friction_W") - reading.number("spool_shaft_power_W"),
    )


def causes(reading: Reading) -> tuple[Loss, ...]:
    """The losses as the analytic formulas divide them.

    In the simulation, compressing the inlet volume costs throttling power: it is part of the transition there.
    """

    def analytic(key: str) -> float:
        return reading.number(f"analytic_loss_{key}_W")

    other = sum(reading.number(f"loss_{key}_W") for key in ("pump_leakage", "pump_friction", "coupling"))
    return (
        Loss("fully open valve", reading.number("loss_full_open_W"), analytic("full_open")),
        Loss(
            "transition and\ncompression",
            reading.number("loss_transition_W"),
            analytic("transition") + analytic("compressibility"),
        ),
        Loss("valve leakage", reading.number("loss_valve_leakage_W"), analytic("leakage")),
        Loss("pump, coupling", other),
    )
