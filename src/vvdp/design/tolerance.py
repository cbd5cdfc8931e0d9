"""What scatter of parts and oil does to drop, frequency and efficiency, and which of it matters.

Distributions come from evenly spread draws, the shares of the variance from Saltelli's scheme for Sobol's indices.
"""

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from vvdp.base.arrays import Array
from vvdp.base.display import percent, with_unit
from vvdp.base.errors import ConfigError, Fault, ParameterError
from vvdp.base.extras import require
from vvdp.base.kinds import Kind
from vvdp.base.params import field_kinds
from vvdp.base.tables import nearest
from vvdp.base.units import parse
from vvdp.design.problem import require_flow
from vvdp.design.quantities import Quantities, Setup, loose_copy, quantities, setup, switching_condition
from vvdp.fluid.oil import Oil
from vvdp.systems.system import System
from vvdp.valve.losses import range_warnings
from vvdp.valve.rotary import RotaryValve

OUTPUTS = ("pressure_drop_total", "pwm_frequency", "efficiency")
SAMPLES = 1024
COARSE = 0.15
"""Half width of the 95 % confidence of a share of the variance from which on it is told that samples are few."""
_STATEMENT = re.compile(r"\s*(\w+)\s*:\s*(.+?)\s+to\s+(.+?)\s*\Z")


@dataclass(frozen=True)
class Spread:
    """Between which values [SI] an input lies, evenly (or evenly in its logarithm), and who says so."""

    name: str
    label: str
    kind: Kind
    low: float
    high: float
    logarithmic: bool
    status: str
    source: str
    note: str

    def quantile(self, share: Any) -> Any:
        """The value below which the share `share` of all draws lies."""
        if self.logarithmic:
            return self.low * (self.high / self.low) ** share
        return self.low + share * (self.high - self.low)

    def __str__(self) -> str:
        return f"{with_unit(self.low, self.kind)} to {with_unit(self.high, self.kind)}"


def usual_spreads(at: Setup) -> tuple[Spread, ...]:
    """The spreads around a setup that are taken where nobody gives others."""
    valve, oil = at.valve, at.oil
    of_valve, of_oil = field_kinds(RotaryValve), field_kinds(Oil)

    def around(name: str, label: str, share: float, status: str, source: str, note: str) -> Spread:
        value, kind = getattr(valve, name), of_valve[name]
        assert kind
        return Spread(
            name=name, label=label, kind=kind, low=(1.0 - share) * value, high=(1.0 + share) * value,
            logarithmic=False, status=status, source=source, note=note,
        )  # fmt: skip

    clearance, viscosity, air = of_valve["radial_clearance"], of_oil["viscosity_40"], of_oil["air_fraction"]
    assert clearance and viscosity and air
    c, nu = valve.radial_clearance, oil.viscosity_40
    half = min(3e-6, 0.5 * c)
    return (
        Spread(
            name="radial_clearance", label="radial clearance", kind=clearance, low=c - half, high=c + half,
            logarithmic=False, status="derived", source="iso286",
            note="spool and sleeve each within grade IT4, 6 µm on 18 to 30 mm of diameter",
        ),
        Spread(
            name="viscosity", label="viscosity of the oil", kind=viscosity, low=0.9 * nu, high=1.1 * nu,
            logarithmic=False, status="published", source="iso3448",
            note="a viscosity grade is 10 % to either side at 40 °C; the same part at 100 °C",
        ),
        Spread(
            name="air_fraction", label="free air in the oil", kind=air, low=1e-3, high=5e-2,
            logarithmic=True, status="assumed", source="", note="0.1 to 5 %, evenly in the logarithm",
        ),
        around(
            "nozzle_discharge_coefficient", "discharge coefficient, nozzles", 0.05, "assumed", "",
            "5 % to either side; the edges of the nozzles are not specified",
        ),
        around(
            "outlet_discharge_coefficient", "discharge coefficient, outlet", 0.05, "assumed", "", "5 % to either side",
        ),
        around(
            "centre_coefficient", "coefficient, centre section", 0.06, "derived", "wang2017",
            "its fit leaves 0.05 bar of 0.81 bar",
        ),
    )  # fmt: skip


def spreads(system: System, texts: Iterable[str] = ()) -> tuple[Spread, ...]:
    """The usual spreads, replaced by those of `texts`, such as "radial_clearance: 10 um to 16 um".

    Raises ConfigError with all that is wrong.
    """
    found = {each.name: each for each in usual_spreads(setup(system))}
    option, faults = "--spread", []
    for text in texts:
        match = _STATEMENT.match(text)
        if not match:
            faults.append(Fault(option, 0, text, 'expected for example "radial_clearance: 10 um to 16 um"'))
            continue
        name = match[1]
        if name not in found:
            faults.append(Fault(option, 0, name, f"unknown input{nearest(name, list(found))}"))
            continue
        try:
            low, high = (parse(word, found[name].kind) for word in match.groups()[1:])
        except ParameterError as problem:
            faults.append(Fault(option, 0, name, str(problem)))
            continue
        if not low < high:
            faults.append(Fault(option, 0, name, f"{match[2]} to {match[3]}; expected the lower one first"))
            continue
        old = found[name]
        found[name] = replace(old, low=low, high=high, logarithmic=False, status="given", source="", note="")
    if faults:
        raise ConfigError(faults)
    return tuple(found.values())


@dataclass(frozen=True)
class Scatter:
    """How an output spreads: nominal, mean, standard deviation, percentiles by number, and the share of its variance
    that each input explains alone and with all others, with the half widths of their 95 % confidence."""

    nominal: float
    mean: float
    deviation: float
    percentiles: Mapping[str, float]
    alone: Mapping[str, float]
    alone_error: Mapping[str, float]
    whole: Mapping[str, float]
    whole_error: Mapping[str, float]


@dataclass(frozen=True)
class Tolerance:
    """A tolerance study: its spreads, the scatter of every output, and the draws of the distributions."""

    system: System
    spreads: tuple[Spread, ...]
    scatter: Mapping[str, Scatter]
    inputs: Mapping[str, Array]
    outputs: Mapping[str, Array]
    evaluations: int
    samples: int

    @property
    def warnings(self) -> list[str]:
        """What to know before the numbers are relied on, a sentence each: where the closed form of the losses does not
        hold at the nominal values, and where samples are few."""
        at = setup(self.system)
        condition = switching_condition(at)
        told = list(range_warnings(at.duty_ratio, condition, at.valve))
        worst = max(max(each.whole_error.values()) for each in self.scatter.values())
        if worst > COARSE:
            told.append(
                f"with {self.samples} samples the shares of the variance are uncertain by up to {percent(worst, 0)} "
                f"of the whole (95 % confidence) and need not sum to 100 %; give more --samples, for example {SAMPLES}"
            )
        return told


PERCENTILES = ("2.5", "16", "50", "84", "97.5")


def tolerance(system: System, taken: Sequence[Spread], *, samples: int = SAMPLES, seed: int = 1) -> Tolerance:
    """The study of a system with the spreads `taken`; `samples` is a power of two.

    Raises ParameterError where the number of samples is none, ConfigError where nothing flows through the valve or to
    the load.
    """
    require("SALib", "opt", "a tolerance study")
    require_flow(system)
    if samples < 8 or samples & (samples - 1):
        raise ParameterError(f"{samples} samples; expected a power of two from 8 on, for example {SAMPLES}")
    from SALib.analyze import sobol as analysis
    from SALib.sample import sobol as sampling
    from scipy.stats import qmc

    at, names = setup(system), [each.name for each in taken]
    nominal = quantities(at)
    if not nominal.efficiency > 0.0:
        raise ConfigError([Fault(system.name, 0, "operation.duty_ratio", _nothing_left(at, nominal))])
    cube = {"num_vars": len(names), "names": names, "bounds": [[0.0, 1.0]] * len(names)}
    shares = sampling.sample(cube, samples, calc_second_order=False, seed=seed)
    drawn = _evaluate(at, taken, shares)
    even = qmc.Sobol(len(names), seed=seed).random(max(4096, 2 * samples))
    spread_out = _evaluate(at, taken, even)
    scatter = {}
    for name in OUTPUTS:
        # Sobol's estimators lose digits where the mean is large against the scatter.
        centred = (drawn[name] - np.mean(drawn[name])) / (np.std(drawn[name]) or 1.0)
        found = analysis.analyze(cube, centred, calc_second_order=False, seed=seed)
        indices = [dict(zip(names, map(float, found[each]), strict=True)) for each in INDICES]
        scatter[name] = _scatter(float(getattr(nominal, name)), spread_out[name], indices)
    return Tolerance(
        system=system,
        spreads=tuple(taken),
        scatter=scatter,
        inputs={each.name: each.quantile(even[:, k]) for k, each in enumerate(taken)},
        outputs=spread_out,
        evaluations=shares.shape[0] + even.shape[0],
        samples=samples,
    )


INDICES = ("S1", "S1_conf", "ST", "ST_conf")
"""What SALib calls the shares of an input alone and with all others, and their half widths."""


def _scatter(nominal: float, column: Array, indices: Sequence[Mapping[str, float]]) -> Scatter:
    """The scatter of an output from its draws and the `INDICES` of its inputs."""
    alone, alone_error, whole, whole_error = indices
    return Scatter(
        nominal=nominal,
        mean=float(np.mean(column)),
        deviation=float(np.std(column, ddof=1)),
        percentiles={each: float(np.percentile(column, float(each))) for each in PERCENTILES},
        alone=alone,
        alone_error=alone_error,
        whole=whole,
        whole_error=whole_error,
    )


def _nothing_left(at: Setup, nominal: Quantities) -> str:
    """Why there is no efficiency to scatter, and from which duty ratio on there is."""
    through = at.flow * (at.load_pressure - at.tank_pressure)
    lost = at.duty_ratio - nominal.load_flow / at.flow + (nominal.loss_leakage + nominal.loss_compressibility) / through
    return (
        f"{at.duty_ratio:g}: analytically, transitions, leakage and compression take all that the load would get, "
        f"so there is no efficiency to scatter; expected more than {lost:.4g}"
    )


def _evaluate(at: Setup, taken: Sequence[Spread], shares: Array) -> dict[str, Array]:
    """The outputs for rows of `shares`, each between 0 and 1, in the order of the spreads."""
    found = quantities(with_inputs(at, {each.name: each.quantile(shares[:, k]) for k, each in enumerate(taken)}))
    return {name: np.broadcast_to(np.asarray(getattr(found, name)), len(shares)).copy() for name in OUTPUTS}


def with_inputs(at: Setup, values: Mapping[str, Any]) -> Setup:
    """`at` with inputs at `values` [SI], which may be arrays; a viscosity is that at 40 degC and carries the one at
    100 degC along."""
    valve, oil = loose_copy(at.valve), loose_copy(at.oil)
    for name, value in values.items():
        if name == "viscosity":
            oil.viscosity_40, oil.viscosity_100 = value, value / at.oil.viscosity_40 * at.oil.viscosity_100
        else:
            setattr(oil if name == "air_fraction" else valve, name, value)
    return at._replace(valve=valve, oil=oil)
