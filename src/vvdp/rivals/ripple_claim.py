"""Claim: the ripple falls with the PWM frequency and with the gas volume of the accumulator."""

from collections.abc import Callable
from dataclasses import replace

from vvdp.base.display import number, percent
from vvdp.base.kinds import EFFICIENCY, NUMBER
from vvdp.results.chart import Chart
from vvdp.results.result import Finding, numbers_of
from vvdp.results.verdict import bound_statement
from vvdp.rigs.ripple import line_capacity, power_of, ripple, ripple_panel, with_gas
from vvdp.rivals.claim import Claim
from vvdp.simulation.link import quiet
from vvdp.steady.test_stand import Stand

FREQUENCIES, SIZES = (20.0, 30.0, 45.0, 60.0, 90.0, 120.0), (0.25, 0.5, 1.0, 2.0, 4.0)
QUANTITIES = {
    "ripple_frequency_exponent": (NUMBER, "exponent of the PWM frequency in the ripple"),
    "ripple_gas_volume_exponent": (NUMBER, "exponent of the gas volume in the ripple"),
    "gas_share_of_line_capacity": (EFFICIENCY, "share of the gas in what the load line takes in"),
}


def ripple_claim(stand: Stand, *, cores: int | None = None, say: Callable[[str], None] = quiet) -> Claim:
    """Ripple over PWM frequency and gas volume. Raises ParameterError where the operating point has no steady state."""
    waves = ripple(stand, [stand.set_point.duty_ratio], FREQUENCIES, SIZES, cores=cores, say=say)
    _, f, v, *_ = waves.tables.values()  # over duty ratio, PWM frequency, gas volume
    tables = {
        "ripple_frequency": replace(f, title="Ripple over PWM frequency"),
        "ripple_volume": replace(v, title="Ripple over gas volume"),
    }
    pressure = stand.set_point.load_pressure
    share = 1.0 - line_capacity(pressure, with_gas(stand, 0.0)) / line_capacity(pressure, with_gas(stand, 1.0))
    numbers = {
        "ripple_frequency_exponent": power_of(f["pwm_frequency_Hz"], f["load_ripple_Pa"]),
        "ripple_gas_volume_exponent": power_of(v["gas_volume_m3"], v["load_ripple_Pa"]),
        "gas_share_of_line_capacity": float(share),
    }
    words = (
        "The ripple goes with the PWM frequency to the power "
        f"{number(numbers['ripple_frequency_exponent'], 3)} and with the gas volume to the power "
        f"{number(numbers['ripple_gas_volume_exponent'], 3)}; the gas is {percent(share, 0)} of what the line takes in."
    )
    return Claim(
        tables=tables,
        charts=(_chart(),),
        numbers=numbers_of(numbers, QUANTITIES),
        findings=(Finding(text=words),),
        statements=(
            (
                "section-1.2.1",
                bound_statement(
                    "exponent of the PWM frequency in the ripple",
                    numbers["ripple_frequency_exponent"],
                    NUMBER,
                    high=0.0,
                    source="the faster, the smaller the ripple",
                ),
            ),
        ),
    )


def _chart() -> Chart:
    return Chart(
        name="ripple",
        caption="Ripple of the load pressure over PWM frequency and gas volume. Dashed: the estimate.",
        table="ripple_frequency",
        panels=(
            ripple_panel("ripple_frequency", "pwm_frequency_Hz", "load, peak to peak"),
            ripple_panel("ripple_volume", "gas_volume_m3", "load, peak to peak"),
        ),
        side_by_side=True,
        height=2.5,
    )
