"""What the page of a run shows of any circuit; a system that brings more along has contents of its own."""

from collections.abc import Iterator

from vvdp.report.circuit import Lines
from vvdp.report.drawing import Drawn, drawn
from vvdp.report.figures import detail, losses, motion, whole
from vvdp.report.html import text
from vvdp.report.reading import BAR, LPM, Reading
from vvdp.report.tables import loss_table
from vvdp.report.verdict import Badge, Notice, cavitating, manner, notices, settling, trust
from vvdp.report.wording import fixed, number, plain
from vvdp.systems.overview import flow_lines, loss_lines, node_lines, power_lines


class Contents:
    """The parts of a page that depend on what was simulated."""

    def __init__(self, reading: Reading) -> None:
        self.reading = reading

    def badges(self) -> Iterator[Badge]:
        """The state of the run in a few words."""
        yield from trust(self.reading)
        if self.reading.results.mark_times.size:
            yield from settling(self.reading)
        yield from cavitating(self.reading)
        yield from manner(self.reading)

    def notices(self) -> Iterator[Notice]:
        """Everything wrong with the run, gravest first."""
        yield from notices(self.reading)

    def in_words(self) -> str:
        """The result in one paragraph."""
        n, found = self.reading.number, self.reading.results.summary
        span = f"{number(n('averaged_from_s'), 3)} s to {number(n('averaged_to_s'), 3)} s"
        powers = dict(power_lines(self.reading.system, found))
        put_in = sum(power for power in powers.values() if power > 0.0)
        taken = -sum(power for power in powers.values() if power < 0.0)
        lost = sorted(loss_lines(self.reading.system, found), key=lambda line: -line.loss)
        words = f"Over the time from {span} the circuit took in {_power(put_in)}"
        words += f" and gave {_power(taken)} to the outside" if taken > 0.0 else ""
        words += f"; its components turned {_power(sum(line.loss for line in lost))} to heat"
        if lost and lost[0].loss > 0.0:
            words += f", most of it, {_power(lost[0].loss)}, in {lost[0].component}"
        highest = max((line for line in node_lines(self.reading.system, found) if line.quantity == "pressure"),
                      key=lambda line: line.high, default=None)  # fmt: skip
        if highest is not None:
            words += f". The highest pressure was {fixed(highest.high / BAR, 1)} bar, at {highest.name}"
        return words + "."

    def key_numbers(self) -> str:
        """Numbers that this system adds to those by node and component, as HTML."""
        return ""

    def values(self) -> dict[str, Lines]:
        """Lines of text in the diagram by name of node or component: mean pressures and flows."""
        found = self.reading.results.summary
        lines: dict[str, list[str]] = {}
        for node in node_lines(self.reading.system, found):
            if node.quantity == "pressure" and (node.low != node.high or node.name in self.reading.volumes):
                lines[node.name] = [f"mean {fixed((node.mean or 0.0) / BAR, 1)} bar"]
        for flow in flow_lines(self.reading.system, found):
            if flow.port == "":
                lines[flow.component] = [f"mean {fixed(flow.flow / LPM, 2)} lpm"]
            else:
                port = f"{flow.port} {fixed(flow.flow / LPM, 2)} lpm"
                lines.setdefault(flow.component, []).append(port)
        return {name: tuple(texts) for name, texts in lines.items()}

    def course(self) -> Iterator[Drawn]:
        """The figures of the course of the run."""
        yield from detail(self.reading)
        yield from whole(self.reading)
        yield from motion(self.reading)
        yield from self.own()

    def own(self) -> Iterator[Drawn]:
        """The figures that the system itself brings along."""
        extras = self.reading.system.extras
        for each in () if extras is None else extras.figures(self.reading.results):
            yield drawn(each.name, each.caption, each.height, each.draw)

    def remark_on_course(self, drawn: tuple[Drawn, ...]) -> str:  # noqa: ARG002
        """What is to be said below the figures `drawn`, as HTML."""
        return ""

    def losses(self) -> Iterator[Drawn]:
        """The figures of losses."""
        yield from losses(self.reading)

    def loss_tables(self) -> str:
        """The tables of losses and what is to be said of them, as HTML."""
        return loss_table(self.reading)

    def circuit_caption(self) -> str:
        """The words below the diagram."""
        begin, end = (plain(self.reading.number(f"averaged_{which}_s"), 4) for which in ("from", "to"))
        return text(
            f"The circuit with the values of this run, and mean pressures (gauge) and flows from {begin} s to {end} s; "
            "flows are counted in volumes at tank conditions, into a port where one is named."
        )


def _power(watt: float) -> str:
    return f"{fixed(1e-3 * watt, 2)} kW" if abs(watt) >= 1e3 else f"{number(watt, 3)} W"
