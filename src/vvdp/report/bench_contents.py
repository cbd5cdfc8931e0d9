"""What the page of a test bench of the rotary valve shows beside what any page does."""

from collections.abc import Iterator

from vvdp.base.signal import signal_value
from vvdp.fluid.oil import density
from vvdp.report import bench_figures
from vvdp.report.bench_tables import key_numbers, loss_tables
from vvdp.report.contents import Contents
from vvdp.report.drawing import Drawn
from vvdp.report.html import text
from vvdp.report.reading import BAR, LPM, Reading
from vvdp.report.verdict import Badge, Notice, cavitating, manner, notices, settling, trust
from vvdp.report.wording import fixed, number, percent, plain
from vvdp.simulation.outcome import SETTLED
from vvdp.systems.bench import RotaryBench
from vvdp.valve.condition import Condition
from vvdp.valve.losses import range_warnings


class BenchContents(Contents):
    """The parts of the page of a bench."""

    def __init__(self, reading: Reading, bench: RotaryBench) -> None:
        super().__init__(reading)
        self.bench = bench

    def badges(self) -> Iterator[Badge]:
        """The state of the run in a few words."""
        yield from trust(self.reading)
        yield from settling(self.reading)
        yield from cavitating(self.reading)
        overloaded = self.reading.has("motor_overloaded")
        yield Badge("motor overloaded", "bad") if overloaded else Badge("motor within its rating", "good")
        yield from manner(self.reading)

    def notices(self) -> Iterator[Notice]:
        """Everything wrong with the run, gravest first."""
        yield from notices(self.reading)
        if self.reading.has("motor_overloaded"):
            power, rated = self.reading.number("input_power_W"), self.reading.number("motor_rated_power_W")
            yield Notice(
                "Motor overloaded",
                f"The pump takes {number(1e-3 * power, 3)} kW on average; the motor is rated "
                f"{number(1e-3 * rated, 3)} kW ({percent(power / rated, 0)}).",
                "Lower the pump speed, the load pressure or the relief setting, or fit a larger motor.",
                True,
            )
        if not self.reading.number("averaged_periods") >= 1:
            yield Notice(
                "No PWM period in the averaging window",
                "The spool did not pass two marks: means are taken over plain time and "
                "belong to whatever opening it stood at.",
                "If the spool should turn, look at initial.spool_speed, spool_drive and the friction; or let the "
                "run last longer.",
            )
        elif not self.reading.has("settled"):
            wanted = " Something prescribed changes over time; then this may be what was asked for."
            yield Notice(
                "Not settled",
                f"The mean PWM frequency still differs by more than {percent(SETTLED)} between the two halves of the "
                f"averaging window of {plain(self.reading.number('averaged_periods'))} periods.",
                "Let the run last longer (run.until), average later (run.average_from), or start closer to the final "
                "spool speed." + (wanted if self.reading.varies else ""),
            )

    def in_words(self) -> str:
        """The result in one paragraph."""
        n = self.reading.number
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
            f"{fixed(n('mean_pump_flow_m3_s') / LPM, 2)} lpm ({percent(n('load_flow_fraction'))}) at a mean pressure "
            f"of {fixed(n('pressure_mean_load_line_Pa') / BAR, 1)} bar, {switching}. Of the power put in, "
            f"{percent(n('efficiency'))} reached the load: {fixed(1e-3 * n('load_power_W'), 2)} kW. The pump takes "
            f"{fixed(1e-3 * power, 2)} kW, {percent(power / rated, 0) if rated > 0 else '–'} of the motor's "
            f"{fixed(1e-3 * rated, 2)} kW.{driven}"
        )

    def key_numbers(self) -> str:
        """Flows, pressures, speeds and powers of the bench."""
        return key_numbers(self.reading, self.bench)

    def course(self) -> Iterator[Drawn]:
        """The figures of the course of the run."""
        yield from bench_figures.course(self.reading, self.bench)
        yield from self.own()

    def remark_on_course(self, drawn: tuple[Drawn, ...]) -> str:
        """What is to be said below the figures, as HTML."""
        if any(each.name == "spectrum" for each in drawn):
            return ""
        return '<p class="small">No spectrum: too few finely recorded rows.</p>'

    def losses(self) -> Iterator[Drawn]:
        """The figure of the losses by component and by cause."""
        yield from bench_figures.losses(self.reading)

    def loss_tables(self) -> str:
        """The losses by component and by cause, the latter beside the analytic ones."""
        return "\n".join([loss_tables(self.reading), *self._on_analytic_losses()])

    def _on_analytic_losses(self) -> Iterator[str]:
        if "analytic_loss_total_W" not in self.reading.results.summary:
            yield (
                "<p>There are no analytic losses here: they need a running pump and a load pressure above the "
                "tank's.</p>"
            )
            return
        yield (
            "<p>The analytic formulas count volumes (the oil keeps its volume under pressure), with ideal conditions: "
            "constant load pressure, an ideal relief valve, ports that open at constant speed. Differences of 1 to "
            "2 % are to be expected. Their sum is an upper estimate, because part of the compression happens while "
            "flow would be lost over the relief valve anyway. In the simulation compression shows as throttling, so "
            "it is counted within the transition.</p>"
        )
        if self.reading.varies:
            yield "<p>Something prescribed changes during this run; the analytic values belong to its start.</p>"
        if self.bench.is_driven:
            yield "<p>The analytic values are those of a spool that nothing drives but the flow.</p>"
        if notes := self._range_notes():
            yield '<div class="notice"><strong>The analytic transition loss is in doubt here</strong>'
            yield "".join(f"<p>{text(note[:1].upper() + note[1:])}.</p>" for note in notes) + "</div>"

    def _range_notes(self) -> tuple[str, ...]:
        """What puts the analytic transition loss in doubt at the start of the run."""
        bench, flow = self.bench, self.bench.nominal_flow
        if flow <= 0.0:
            return ()
        at = Condition(
            flow=flow,
            load_pressure=self.reading.number("pressure_mean_load_line_Pa") + bench.reference,
            relief_pressure=bench.relief_valve.cracking_pressure,
            tank_pressure=signal_value(0.0, bench.operation.tank_pressure),
            density=density(signal_value(0.0, bench.operation.oil_temperature), bench.oil),
        )
        return range_warnings(signal_value(0.0, bench.duty_ratio), at, bench.valve)
