"""Findings to read before the numbers of a run: is it to be trusted, and what lies outside its bounds."""

from collections.abc import Iterator

import numpy as np

from vvdp.base.display import number, percent, plain, with_unit
from vvdp.base.kinds import DURATION, MEAN_POWER
from vvdp.evaluation.bench_report import BenchReport
from vvdp.evaluation.bench_validity import efficiency_doubt
from vvdp.evaluation.overview import (
    expects_steady_state,
    impossible_part,
    loss_lines,
    node_lines,
    power_lines,
)
from vvdp.evaluation.summary import is_closed
from vvdp.evaluation.validity import broken_bounds
from vvdp.results.result import Badge, Finding, Grade, sentences
from vvdp.runs.run import RecordedRun
from vvdp.simulation.balance import LIMIT
from vvdp.simulation.outcome import SETTLED
from vvdp.systems.assumed import assumed_words
from vvdp.systems.spool_travel import travel_warnings


def badges(run: RecordedRun) -> Iterator[Badge]:
    """The state of a run in a few words."""
    if "trusted" not in run.summary:
        yield Badge("not checked: no balances", Grade.WARNING)
    else:
        closed = is_closed(run.summary)
        yield Badge("balances close", Grade.GOOD) if closed else Badge("BALANCES DO NOT CLOSE", Grade.BAD)
        if not run.has("second_law"):
            yield Badge("IMPOSSIBLE", Grade.BAD)
    if not run.has("within_validity"):
        yield Badge("outside the range of a law", Grade.BAD)
    if not run.has("finished"):
        yield Badge("interrupted", Grade.BAD)
    yield _settling_badge(run)
    if run.has("cavitation_volume"):
        yield Badge("cavitation", Grade.BAD)
    if "motor_overloaded" in run.summary:
        over = run.has("motor_overloaded")
        yield Badge("motor overloaded", Grade.BAD) if over else Badge("motor within its rating", Grade.GOOD)
    if run.has("stiff_method"):
        yield Badge("stiff method at the end")
    yield Badge(assumed_words(run.system.assumptions))


def warnings(run: RecordedRun) -> Iterator[Finding]:
    """Warnings about the run of any circuit, gravest first."""
    if "trusted" in run.summary and not is_closed(run.summary):
        energy, mass = (number(run.number(f"{name}_residual"), 3) for name in ("energy", "mass"))
        tolerance = plain(float(run.meta["relative_tolerance"]))
        yield Finding(
            grade=Grade.BAD,
            title="The balances do not close",
            text=f"Energy residual {energy}, oil residual {mass} of the throughput; the limit is {plain(LIMIT)}.",
            remedy="Do not use these numbers. Run again with a smaller run.relative_tolerance (it was "
            f"{tolerance}; try a tenth of it). If the residual stays, the circuit's equations lose oil or energy: "
            "report it.",
        )
    if not run.has("finished"):
        reached, until = run.number("duration_s"), float(run.meta["until_s"])
        yield Finding(
            grade=Grade.BAD,
            title="Interrupted run",
            text=f"The run was stopped at {with_unit(reached, DURATION)} of {with_unit(until, DURATION)}. "
            "Means are taken over the part that was simulated.",
            remedy="Run again to the end, or ask for a shorter run with --until.",
        )
    if not run.summary.get("second_law", True):
        part = impossible_part(run.system, run.summary)
        yield Finding(
            grade=Grade.BAD,
            title="This cannot be",
            text=f"{part[:1].upper()}{part[1:]}.",
            remedy="Do not use these numbers. Look for a value with the wrong sign or unit.",
        )
    yield from _range_warnings(run)
    yield from _fault_warnings(run)
    yield from _drawing_warnings(run)
    if not run.has("settled") and expects_steady_state(run.system, run.summary):
        yield _settling_warning()


def _settling_badge(run: RecordedRun) -> Badge:
    if run.number("averaged_periods") < 1 and "pwm_frequency_Hz" in run.summary:
        return Badge(f"no {run.period}", Grade.WARNING)
    if run.has("settled"):
        return Badge("settled", Grade.GOOD)
    steady = expects_steady_state(run.system, run.summary)
    return Badge("not settled", Grade.WARNING) if steady else Badge("varies by design")


def _settling_warning() -> Finding:
    return Finding(
        grade=Grade.WARNING,
        title="Not settled",
        text=f"A mean would still change by more than {percent(SETTLED)} if the run went on.",
        remedy="Let the run last longer (run.until), average later (run.average_from), or start closer to where it "
        "settles.",
    )


def _fault_warnings(run: RecordedRun) -> Iterator[Finding]:
    for fault in run.system.faults:
        yield Finding(
            grade=Grade.WARNING,
            title="Fault",
            text=f"{fault.sentence[:1].upper()}{fault.sentence[1:]}.",
            remedy="The file states this in its table [faults]; the numbers are those of the machine with it.",
        )


def _drawing_warnings(run: RecordedRun) -> Iterator[Finding]:
    for sentence in travel_warnings(run.system):
        yield Finding(
            grade=Grade.WARNING,
            title="Travel of the spool",
            text=f"{sentence[:1].upper()}{sentence[1:]}.",
            remedy="The numbers are those of the drive and helix as given. Make end stops, helix and [geometry] agree.",
        )


def _range_warnings(run: RecordedRun) -> Iterator[Finding]:
    for sentence in broken_bounds(run.system, run.summary):
        yield Finding(
            grade=Grade.BAD,
            title="Outside the range of a law",
            text=f"{sentence[:1].upper()}{sentence[1:]}.",
            remedy="The numbers are those of the equations, not of the machine. docs/design.md shows the ranges.",
        )


def bench_warnings(run: RecordedRun, bench: BenchReport) -> Iterator[Finding]:
    """Warnings about the run of a test rig of the rotary valve."""
    if run.has("motor_overloaded"):
        power, rated = run.number("input_power_W"), run.number("motor_rated_power_W")
        yield Finding(
            grade=Grade.BAD,
            title="Motor overloaded",
            text=f"The pump takes {with_unit(power, MEAN_POWER)} on average; the motor is rated "
            f"{with_unit(rated, MEAN_POWER)} ({percent(power / rated, 0)}).",
            remedy="Lower the pump speed, the load pressure or the relief setting, or fit a larger motor.",
        )
    put_in = run.number("input_power_W") + run.number("spool_motor_power_W")
    if doubt := efficiency_doubt(run.number("load_power_W"), put_in, run.number("stored_power_W")):
        yield Finding(
            grade=Grade.WARNING,
            title="No efficiency",
            text=f"{doubt[:1].upper()}{doubt[1:]}.",
            remedy="Average over a time in which as much energy is stored as is released, or over a longer one.",
        )
    if not np.isfinite(run.number("loss_transition_W")):
        yield Finding(
            grade=Grade.WARNING,
            title="No loss by transition",
            text="The valve loss is below that of one fully open port: there is no fully open valve to compare with.",
        )
    if not run.number("averaged_periods") >= 1:
        yield Finding(
            grade=Grade.WARNING,
            title="No PWM period in the averaging window",
            text="Fewer than two PWM periods were completed: means are taken over plain time and belong to whatever "
            "opening the spool stood at.",
            remedy="If the spool should turn, look at initial.spool_speed, spool_drive and the friction; or let the "
            "run last longer.",
        )
    yield from sentences(tuple(bench.program_warnings(run.summary)), Grade.WARNING)


def in_words(run: RecordedRun) -> str:
    """The result of a run of any circuit in one paragraph."""
    begin, end = (with_unit(run.number(f"averaged_{which}_s"), DURATION, 3) for which in ("from", "to"))
    powers = dict(power_lines(run.system, run.summary))
    put_in = sum(power for power in powers.values() if power > 0.0)
    taken = -sum(power for power in powers.values() if power < 0.0)
    lost = sorted(loss_lines(run.system, run.summary), key=lambda line: -line.loss)
    words = f"From {begin} to {end} the circuit took in {_power(put_in)}"
    words += f" and gave {_power(taken)} to its load" if taken > 0.0 else ""
    words += f"; its components dissipated {_power(sum(line.loss for line in lost))}"
    if lost and lost[0].loss > 0.0:
        words += f", most of it, {_power(lost[0].loss)}, in {lost[0].component}"
    pressures = [line for line in node_lines(run.system, run.summary) if line.quantity == "pressure"]
    if pressures:
        highest = max(pressures, key=lambda line: line.high)
        words += f". The highest pressure was {with_unit(highest.high, highest.kind)}, at {highest.name}"
    return words + "."


def bench_in_words(run: RecordedRun) -> str:
    """The result of a run of a test rig in one paragraph."""
    n, numbers = run.number, run.numbers
    text = {key: with_unit(each.value, each.kind) for key, each in numbers.items()}
    periods = n("averaged_periods")
    span = f"{with_unit(n('averaged_from_s'), DURATION, 3)} to {with_unit(n('averaged_to_s'), DURATION, 3)}"
    over = f"Over {plain(periods)} whole PWM periods ({span})" if periods >= 1 else f"From {span}"
    frequency = f"while the valve switched at {text['pwm_frequency_Hz']}"
    rated = f" ({percent(n('input_power_W') / n('motor_rated_power_W'), 0)})" if n("motor_rated_power_W") > 0.0 else ""
    driven = f" The spool's own motor takes {text['spool_motor_power_W']}." if n("spool_motor_power_W") else ""
    return (
        f"{over} the load received {text['mean_load_flow_m3_s']} of the pump's {text['mean_pump_flow_m3_s']} "
        f"({text['load_flow_fraction']}) at a mean pressure of {text['pressure_mean_load_line_Pa']}, "
        f"{frequency if periods >= 1 else 'without the valve switching'}. Of the input power, {text['efficiency']} "
        f"reached the load: {text['load_power_W']}. The pump takes {text['input_power_W']} of the motor's "
        f"{text['motor_rated_power_W']}{rated}.{driven}"
    )


def _power(watt: float) -> str:
    return with_unit(watt, MEAN_POWER, 3)
