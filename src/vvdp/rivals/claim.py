"""A calculated claim: numbers, tables, figures and sentences."""

from collections.abc import Mapping
from dataclasses import dataclass

from vvdp.results.chart import Chart
from vvdp.results.result import Finding, Number, Table
from vvdp.results.verdict import Statement


@dataclass(frozen=True, kw_only=True)
class Claim:
    """One claim, calculated for a system. `statements` are those of the source that it judges, under their sections."""

    tables: Mapping[str, Table]
    charts: tuple[Chart, ...]
    numbers: Mapping[str, Number]
    findings: tuple[Finding, ...]
    statements: tuple[tuple[str, Statement], ...] = ()
