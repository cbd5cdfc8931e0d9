"""Between which values the inputs of a tolerance study lie, and who states this."""

import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from vvdp.base.display import with_unit
from vvdp.base.errors import ConfigError, Fault, ParameterError
from vvdp.base.kinds import Kind
from vvdp.base.tables import Sourced, nearest
from vvdp.base.units import parse
from vvdp.design.quantities import Setup, loose_copy
from vvdp.evaluation.bench import RotaryBench
from vvdp.evaluation.range_display import value_words
from vvdp.systems.system import System

WIDE = 10.0
"""A spread whose ends lie further apart than so many times is even in its logarithm."""
_STATEMENT = re.compile(r"\s*([\w.]+)\s*:\s*(.+?)\s+to\s+(.+?)\s*\Z")
SHORT = {"oil.viscosity_40": "viscosity"}
"""Names of inputs that are not their key: the viscosity at 100 degC goes along."""
OF_SETUP = {
    "relief_valve.cracking_pressure": "relief_pressure",
    "relief_valve.override_pressure": "relief_override",
    "inlet.volume": "inlet_volume",
    "load.pressure": "load_pressure",
    "operation.oil_temperature": "temperature",
    "operation.duty_ratio": "duty_ratio",
    "operation.spool_motor_speed": "spool_motor_speed",
}
"""Values around the valve and the oil that closed forms know, and their names there."""


@dataclass(frozen=True)
class Spread:
    """Between which values [SI] an input lies, evenly (or evenly in its logarithm), and who states this.

    `setting` is its table and key, `nominal` its value as it is.
    """

    setting: str
    label: str
    kind: Kind
    nominal: float
    low: float
    high: float
    status: str
    source: str
    note: str

    @property
    def name(self) -> str:
        """Name in tables: the key of a value of valve or oil, else table and key."""
        table, _, key = self.setting.rpartition(".")
        return SHORT.get(self.setting, key if table in ("valve", "oil") else self.setting.replace(".", "_"))

    @property
    def is_logarithmic(self) -> bool:
        """Whether it is even in its logarithm."""
        return self.low > 0.0 and self.high > WIDE * self.low

    @property
    def in_closed_forms(self) -> bool:
        """Whether closed forms know the input."""
        return self.setting.startswith(("valve.", "oil.")) or self.setting in OF_SETUP

    def quantile(self, share: Any) -> Any:
        """The value below which the share `share` of all draws lies."""
        if self.is_logarithmic:
            return self.low * (self.high / self.low) ** share
        return self.low + share * (self.high - self.low)

    def __str__(self) -> str:
        return f"{with_unit(self.low, self.kind)} to {with_unit(self.high, self.kind)}"


USUAL: Mapping[str, tuple[str, float, str, str, str]] = {
    "oil.viscosity_40": (
        "viscosity of the oil", 0.1, "published", "iso3448",
        "a viscosity grade is 10 % to either side at 40 °C; the same part at 100 °C",
    ),
    "valve.nozzle_discharge_coefficient": (
        "discharge coefficient, nozzles", 0.05, "assumed", "",
        "5 % to either side; the edges of the nozzles are not specified",
    ),
    "valve.outlet_discharge_coefficient": (
        "discharge coefficient, outlet", 0.05, "assumed", "", "5 % to either side",
    ),
    "valve.centre_coefficient": (
        "coefficient, centre section", 0.06, "derived", "wang2017", "its fit leaves 0.05 bar of 0.81 bar",
    ),
}  # fmt: skip
"""Label, half width over the value, status, source and note of inputs that spread where the file gives no range."""
LABELS = {
    "valve.radial_clearance": "radial clearance",
    "oil.air_fraction": "free air in the oil",
} | {setting: label for setting, (label, *_) in USUAL.items()}


def usual_spreads(system: System) -> Iterator[Spread]:
    """Scatter of parts and oil where the system file gives no range."""
    rows = {row.setting: row for row in system.rows}
    for setting in ("valve.radial_clearance", "oil.air_fraction", *USUAL):
        row = rows[setting]
        if setting == "valve.radial_clearance":
            half = min(3e-6, 0.5 * row.nominal)
            note = "spool and sleeve each within grade IT4, 6 µm on 18 to 30 mm of diameter"
            yield _spread(row, (row.nominal - half, row.nominal + half), "derived", "iso286", note)
        elif setting == "oil.air_fraction":
            yield _spread(row, (1e-3, 5e-2), "assumed", "", "0.1 to 5 %, evenly in the logarithm")
        else:
            _, share, status, source, note = USUAL[setting]
            yield _spread(row, ((1.0 - share) * row.nominal, (1.0 + share) * row.nominal), status, source, note)


def _spread(row: Sourced, ends: tuple[float, float], status: str, source: str, note: str) -> Spread:
    return Spread(
        setting=row.setting,
        label=LABELS.get(row.setting) or value_words(row),
        kind=row.kind,
        nominal=row.nominal,
        low=ends[0],
        high=ends[1],
        status=status,
        source=source,
        note=note,
    )


def spreads(system: System, texts: Iterable[str] = ()) -> tuple[Spread, ...]:
    """The usual spreads and the ranges of the system file, replaced and joined by those of `texts`, such as
    "radial_clearance: 10 um to 16 um" or "relief_valve.opening_time: 0 ms to 15 ms".

    Raises ConfigError with all that is wrong.
    """
    found = {each.setting: each for each in usual_spreads(system)}
    for row in system.uncertainties:
        assert row.range is not None
        found[row.setting] = _spread(row, row.range, row.status, row.source, row.note)
    rows = {row.setting: row for row in system.rows if row.nominal == row.nominal}
    names = {SHORT.get(setting, row.key): setting for setting, row in rows.items()}
    names |= {each.name: each.setting for each in found.values()}
    faults: list[Fault] = []
    for text in texts:
        match = _STATEMENT.match(text)
        if not match:
            faults.append(Fault(OPTION, 0, text, 'expected for example "radial_clearance: 10 um to 16 um"'))
            continue
        setting = names.get(match[1], match[1])
        if setting not in rows:
            known = [each.name for each in found.values()]
            faults.append(Fault(OPTION, 0, match[1], f"unknown input{nearest(match[1], known)}"))
            continue
        try:
            found[setting] = _spread(rows[setting], _ends(rows[setting].kind, match), "given", "", "")
        except ParameterError as problem:
            faults.append(Fault(OPTION, 0, match[1], str(problem)))
    if faults:
        raise ConfigError(faults)
    return tuple(found.values())


OPTION = "--spread"


def _ends(kind: Kind, match: re.Match[str]) -> tuple[float, float]:
    """Both ends of a statement. Raises ParameterError."""
    low, high = (parse(word, kind) for word in match.groups()[1:])
    if not low < high:
        raise ParameterError(f"{match[2]} to {match[3]}; expected the lower one first")
    return low, high


def with_inputs(at: Setup, values: Mapping[str, object]) -> Setup:
    """`at` with values [SI] by setting, which may be arrays; those that closed forms do not know are left out.

    A viscosity is that at 40 degC and carries the one at 100 degC along.
    """
    valve, oil, around = loose_copy(at.valve), loose_copy(at.oil), {}
    for setting, value in values.items():
        table, _, key = setting.partition(".")
        if setting in OF_SETUP:
            around[OF_SETUP[setting]] = value
        elif table in ("valve", "oil"):
            setattr(valve if table == "valve" else oil, key, value)
    if "oil.viscosity_40" in values:
        oil.viscosity_100 = oil.viscosity_40 / at.oil.viscosity_40 * at.oil.viscosity_100
    return at._replace(valve=valve, oil=oil, **around)


def bench_with(bench: RotaryBench, values: Mapping[str, float]) -> RotaryBench:
    """A bench with values [SI] by setting. Raises ParameterError where they contradict each other."""
    if "oil.viscosity_40" in values:
        ratio = values["oil.viscosity_40"] / bench.oil.viscosity_40
        values = {**values, "oil.viscosity_100": ratio * bench.oil.viscosity_100}
    return bench.with_values(values)
