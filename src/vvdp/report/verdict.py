"""What a reader has to know before the numbers: is the run to be trusted, and what lies outside its bounds."""

from collections.abc import Iterator
from dataclasses import dataclass

from vvdp.base.signal import signal_value
from vvdp.fluid.oil import density
from vvdp.report.reading import BAR, LPM, Reading
from vvdp.report.wording import fixed, number, percent, plain
from vvdp.simulation.balance import LIMIT
from vvdp.simulation.outcome import SETTLED
from vvdp.valve.losses import range_warnings


@dataclass(frozen=True)
class Badge:
    """A word on the state of the run; `grade` is good, warn, bad or empty."""

    words: str
    grade: str = ""


@dataclass(frozen=True)
class Notice:
    """Something wrong, with its numbers, and what to do about it."""

    title: str
    found: str
    remedy: str
    grave: bool = False


def keeps_books(reading: Reading) -> bool:
    """Whether the run was checked by its balances."""
    return "trusted" in reading.results.summary


def badges(reading: Reading) -> Iterator[Badge]:
    """The state of the run in a few words."""
    if not keeps_books(reading):
        yield Badge("not checked: no balances", "warn")
    elif reading.has("trusted"):
        yield Badge("trusted", "good")
    else:
        yield Badge("NOT TRUSTED", "bad")
    if not reading.has("finished"):
        yield Badge("interrupted", "bad")
    if not reading.number("averaged_periods") >= 1:
        yield Badge("no PWM period", "warn")
    elif reading.has("settled"):
        yield Badge("settled", "good")
    else:
        yield Badge("not settled", "warn")
    yield Badge("cavitation", "bad") if reading.has("cavitation") else Badge("no cavitation", "good")
    yield (
        Badge("motor overloaded", "bad")
        if reading.has("motor_overloaded")
        else Badge("motor within its rating", "good")
    )
    if reading.has("stiff_method"):
        yield Badge("stiff method at the end")
    yield Badge(f"{len(reading.system.assumed)} assumed values")


def notices(reading: Reading) -> Iterator[Notice]:
    """Everything wrong with the run, gravest first."""
    limit = plain(LIMIT)
    if keeps_books(reading) and not reading.has("trusted"):
        energy, mass = (number(reading.number(f"{name}_residual"), 3) for name in ("energy", "mass"))
        tolerance = float(reading.results.meta["relative_tolerance"])
        yield Notice(
            "NOT TRUSTED: the balances do not close",
            f"Energy residual {energy}, mass residual {mass} of the throughput; the limit is {limit}.",
            f"Do not use these numbers. Run again with a smaller run.relative_tolerance (it was {plain(tolerance)}; "
            "try a tenth of it). If the residual stays, the circuit's equations lose oil or energy: report it.",
            True,
        )
    if not reading.has("finished"):
        until = float(reading.results.meta["until_s"])
        yield Notice(
            "Interrupted run",
            f"The run was stopped at {plain(reading.number('duration_s'), 4)} s of {plain(until)} s. "
            "Means cover what was reached.",
            "Run again to the end, or ask for a shorter run with --until.",
            True,
        )
    if reading.has("cavitation"):
        lowest = (reading.number("inlet_pressure_min_Pa") + reading.reference) / BAR
        bound = reading.system.tables["limits"].cavitation_pressure / BAR
        yield Notice(
            "Cavitation at the inlet",
            f"The inlet pressure fell to {fixed(lowest, 3)} bar absolute, "
            f"below the limit of {plain(bound)} bar absolute.",
            "Below the limit the oil model does not hold. Raise the tank pressure, slow the spool or the pump, or "
            "enlarge the tank branch.",
            True,
        )
    if reading.has("motor_overloaded"):
        power, rated = reading.number("input_power_W"), reading.number("motor_rated_power_W")
        yield Notice(
            "Motor overloaded",
            f"The pump takes {number(1e-3 * power, 3)} kW on average; the motor is rated {number(1e-3 * rated, 3)} kW "
            f"({percent(power / rated, 0)}).",
            "Lower the pump speed, the load pressure or the relief setting, or fit a larger motor.",
            True,
        )
    if not reading.number("averaged_periods") >= 1:
        yield Notice(
            "No PWM period in the averaging window",
            "The spool did not pass two marks: means are taken over plain time and "
            "belong to whatever opening it stood at.",
            "If the spool should turn, look at initial.spool_speed, spool_drive and the friction; or let the "
            "run last longer.",
        )
    elif not reading.has("settled"):
        yield Notice(
            "Not settled",
            f"The mean PWM frequency still differs by more than {percent(SETTLED)} between the two halves of the "
            f"averaging window of {plain(reading.number('averaged_periods'))} periods.",
            "Let the run last longer (run.until), average later (run.average_from), or start closer to the final "
            "spool speed."
            + (
                " Something prescribed changes over time; then this may be what was asked for."
                if reading.varies
                else ""
            ),
        )


def range_notes(reading: Reading) -> tuple[str, ...]:
    """What puts the analytic transition loss in doubt at the start of the run."""
    supply, prescribed = reading.supply, reading.operation
    flow = supply.pump.displacement * reading.start(prescribed.pump_speed)
    if flow <= 0.0:
        return ()
    temperature = signal_value(0.0, prescribed.oil_temperature)
    return range_warnings(
        reading.start(reading.duty_ratio),
        flow,
        reading.mean_load_pressure,
        supply.relief_valve.cracking_pressure,
        reading.start(prescribed.tank_pressure),
        density(temperature, supply.oil),
        supply.valve,
    )


def in_words(reading: Reading) -> str:
    """The result in one paragraph."""
    n = reading.number
    periods = n("averaged_periods")
    span = f"{number(n('averaged_from_s'), 3)} s to {number(n('averaged_to_s'), 3)} s"
    over = f"{plain(periods)} whole PWM periods ({span})" if periods >= 1 else f"the time from {span}"
    switching = (
        f"while the valve switched at {fixed(n('pwm_frequency_Hz'), 1)} Hz"
        if periods >= 1
        else "without the valve switching"
    )
    power, rated = n("input_power_W"), n("motor_rated_power_W")
    motor = n("spool_motor_power_W")
    driven = f" The spool's own motor takes {number(motor, 3)} W." if motor else ""
    return (
        f"Over {over} the load received {fixed(n('mean_load_flow_m3_s') / LPM, 2)} lpm of the pump's "
        f"{fixed(n('mean_pump_flow_m3_s') / LPM, 2)} lpm ({percent(n('load_flow_fraction'))}) at a mean pressure of "
        f"{fixed(n('mean_load_pressure_Pa') / BAR, 1)} bar, {switching}. Of the power put in, "
        f"{percent(n('efficiency'))} reached the load: {fixed(1e-3 * n('load_power_W'), 2)} kW. The pump takes "
        f"{fixed(1e-3 * power, 2)} kW, {percent(power / rated, 0) if rated > 0 else '–'} of the motor's "
        f"{fixed(1e-3 * rated, 2)} kW.{driven}"
    )
