"""Reports of the programs of a drawn circuit, each under its name if there are several of a kind."""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from typing import TYPE_CHECKING

from vvdp.programs.report import ProgramReport
from vvdp.results.chart import Chart
from vvdp.results.result import Table
from vvdp.systems.extras import Extras, Line, LoadedSystem, Summary

if TYPE_CHECKING:
    from vvdp.simulation.outcome import Outcome
    from vvdp.simulation.record import Record
    from vvdp.simulation.run import Run


OF_THE_RUN = frozenset({"real_time_factor"})
"""Keys that are the same whichever program reports them."""


def reported_programs(system: LoadedSystem, sample_period: float) -> "ReportedPrograms | None":
    """Reports of the programs of a system; None if there are none. `sample_period` of the run [s]."""
    reports = program_reports(system, sample_period)
    return ReportedPrograms(system, reports) if reports else None


def program_reports(system: LoadedSystem, sample_period: float) -> dict[str, ProgramReport]:
    """The reports of the programs of a system, by name. `sample_period` of the run [s]."""
    network = system.circuit.network
    return {
        name: program.type.report(network, name, sample_period)
        for name, program in network.programs.items()
        if program.type.report is not None
    }


class ReportedPrograms(Extras):
    """The reports of programs, each with what its keys begin with."""

    IS_ALL = False

    def __init__(self, system: LoadedSystem, reports: Mapping[str, ProgramReport]) -> None:
        super().__init__(system)
        self.reports = [
            (f"{name}_" if any(_share_keys(report, other) for other in reports.values()) else "", report)
            for name, report in reports.items()
        ]
        self.STEADY = all(report.STEADY for report in reports.values())
        self.QUANTITIES = {
            prefix + key: (kind, _words(prefix) + label)
            for prefix, report in self.reports
            for key, (kind, label) in report.QUANTITIES.items()
        }
        self.OVERVIEW = tuple(
            Line(
                label,
                tuple(prefix + key for key in keys),
                report.QUANTITIES[keys[0]][0],
                (),
                report.GROUP + _of(prefix),
            )
            for prefix, report in self.reports
            for label, keys in _lines(report)
        )
        self.HEADLINE = tuple(prefix + key for prefix, report in self.reports for key in report.HEADLINE)

    def simulation_numbers(self, run: "Outcome", found: Summary) -> Summary:
        """The numbers of all programs that any run has."""
        return {
            prefix + key: value
            for prefix, report in self.reports
            for key, value in report.outcome_numbers(run, found).items()
        }

    def record_numbers(self, run: "Run") -> Summary:
        """The numbers of all programs that need a record."""
        return {prefix + key: value for prefix, report in self.reports for key, value in report.numbers(run).items()}

    def warnings(self, found: Mapping[str, float | bool]) -> Iterator[str]:
        """Warnings of the programs on a run."""
        for prefix, report in self.reports:
            yield from (_words(prefix) + words for words in report.warnings(_own(prefix, found)))

    def merits(self, found: Mapping[str, float | bool]) -> Iterator[str]:
        """Facts that the numbers of the programs confirm."""
        for prefix, report in self.reports:
            yield from (_words(prefix) + words for words in report.merits(_own(prefix, found)))

    def charts(self, record: "Record") -> Iterable[tuple[Chart, Table]]:
        """The figures of all programs."""
        for prefix, report in self.reports:
            for chart, table in report.charts(record):
                found = replace(chart, name=_words(prefix, "-") + chart.name, table=prefix + chart.table)
                for _, other in self.reports:
                    found = other.complete(found, record)
                yield found, table


def _lines(report: ProgramReport) -> Iterator[tuple[str, tuple[str, ...]]]:
    """The lines of an overview: label, and the keys that are added up."""
    yield from ((label, (key,)) for key, (_, label) in report.QUANTITIES.items() if key not in report.UNSHOWN)
    yield from report.TOGETHER.items()


def _share_keys(one: ProgramReport, other: ProgramReport) -> bool:
    """Whether the keys of `one` need the name of its program beside those of the `other`."""
    if one is other or (one.LEADS and not other.LEADS):
        return False
    return not (one.QUANTITIES.keys() - OF_THE_RUN).isdisjoint(other.QUANTITIES)


def _own(prefix: str, found: Mapping[str, float | bool]) -> Mapping[str, float | bool]:
    """The numbers with those of one program under its own keys."""
    return {**found, **{key.removeprefix(prefix): value for key, value in found.items() if key.startswith(prefix)}}


def _words(prefix: str, between: str = " ") -> str:
    return prefix.removesuffix("_").replace("_", between) + (": " if between == " " else between) if prefix else ""


def _of(prefix: str) -> str:
    return f", {prefix.removesuffix('_').replace('_', ' ')}" if prefix else ""
