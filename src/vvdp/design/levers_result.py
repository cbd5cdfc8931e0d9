"""The levers on the transition loss in one table of watts, with the limit of transitions that lose nothing."""

from collections.abc import Iterator, Sequence

import numpy as np

from vvdp.base.arrays import Array
from vvdp.base.display import percent, with_unit
from vvdp.base.kinds import EFFICIENCY, FREQUENCY, GAUGE_PRESSURE, MEAN_POWER, Kind
from vvdp.design.levers import LOAD_SHARES, Pulled, limit_loss, simulated_loss, valve_loss
from vvdp.design.variables import VARIABLES
from vvdp.results.chart import Bars, Chart, Colour
from vvdp.results.result import Column, Finding, Grade, Number, Result, Section, Table
from vvdp.systems.system import System

CONFIRMED = 0.01
"""Share of its loss by which a lever's simulation in stiff oil may differ from the closed form."""
BALANCED = 1e-6
"""Largest residual of energy and mass."""
MANNER = (
    "Each lever is set to the least mean loss over three load pressures, in closed form, with the PWM frequency of the "
    "open valve at least what it was; then its periodic states are simulated, in oil without compressibility, which "
    "the closed form takes, and in the oil as it is. Losses are those of valve, relief valve and, where there is one, "
    "the spool's motor. The limit is the same valve with transitions that lose nothing."
)


def levers_result(system: System, found: Sequence[Pulled]) -> Result:
    """The study as a result."""
    table, points = _table(found), _points(system, found)
    best = int(np.argmin(table["loss_W"] if "loss_W" in table.columns else table["closed_loss_W"]))
    losses = table["loss_W"] if "loss_W" in table.columns else table["closed_loss_W"]
    numbers = {
        "loss_before_W": Number(float(losses[0]), MEAN_POWER, "loss as it is, mean over the loads"),
        "loss_after_W": Number(float(losses[best]), MEAN_POWER, "loss with the best lever"),
        "loss_limit_W": Number(float(table["limit_W"][0]), MEAN_POWER, "limit of the valve as it is"),
    }
    return Result(
        verb="design levers",
        title="Levers on the transition loss",
        system=system.name,
        manner=MANNER,
        references=("wang2017",),
        conditions={"loads": ", ".join(percent(share, 0) for share in LOAD_SHARES) + " of the relief setting"},
        left_out=(
            "The spool's seals and bearings, what following the load asks of the relief valve, and the lag of the "
            "check valve and of the chamber's lock.",
            "Leakage and friction of the pump, which are the same for all.",
        ),
        numbers=numbers,
        tables={"levers": table, "loads": points},
        charts={"watts": _chart(table)},
        findings=tuple(_findings(table, best)),
        sections=(
            Section(title="Watts", words=(MANNER,), shows=("watts", "levers")),
            Section(title="By load", shows=("loads",)),
            Section(title="How it was done", shows=("conditions",)),
        ),
    )


def _means(rows: Sequence[Sequence[float]]) -> Array:
    return np.array([float(np.mean(row)) for row in rows])


def _table(found: Sequence[Pulled]) -> Table:
    """A row for each lever, means over the loads."""
    closed = _means([[valve_loss(q) for q in each.closed] for each in found])
    columns = {
        "lever": Column(np.array([each.lever.name for each in found]), None, "lever"),
        "values": Column(np.array([_values(each) for each in found]), None, "at"),
        "pwm_frequency_Hz": Column(_means([[q.pwm_frequency for q in each.closed] for each in found]), FREQUENCY,
                                   "PWM frequency, fully open"),
        "closed_loss_W": Column(closed, MEAN_POWER, "loss, closed form"),
    }  # fmt: skip
    if found[0].real:
        stiff, real = (_means([[simulated_loss(s) for s in getattr(each, oil)] for each in found])
                       for oil in ("stiff", "real"))  # fmt: skip
        columns |= {
            "stiff_loss_W": Column(stiff, MEAN_POWER, "simulated, stiff oil"),
            "difference": Column(stiff / closed - 1.0, EFFICIENCY, "against the closed form"),
            "loss_W": Column(real, MEAN_POWER, "simulated"),
            "saving": Column(1.0 - real / real[0], EFFICIENCY, "saving"),
            "transition_W": Column(_summary_means(found, "loss_transition_W"), MEAN_POWER, "of it transitions"),
            "simulated_pwm_frequency_Hz": Column(
                _summary_means(found, "pwm_frequency_Hz"), FREQUENCY, "PWM frequency, simulated"
            ),
            "efficiency": Column(_summary_means(found, "efficiency"), EFFICIENCY, "efficiency"),
            "residual": Column(_residuals(found), EFFICIENCY, "worst residual"),
        }
    limit = _means([[limit_loss(q) for q in each.closed] for each in found])
    columns["limit_W"] = Column(limit, MEAN_POWER, "lossless limit")
    shown = tuple(key for key in columns if key not in ("stiff_loss_W", "residual"))
    return Table(title="Levers, means over the loads", columns=columns, shown=shown)


def _summary_means(found: Sequence[Pulled], key: str) -> Array:
    return _means([[float(s.summary.get(key, np.nan)) for s in each.real] for each in found])


def _residuals(found: Sequence[Pulled]) -> Array:
    keys = ("energy_residual", "mass_residual")
    states = [(*each.stiff, *each.real) for each in found]
    return np.array([max(abs(float(s.summary.get(key, np.nan))) for s in row for key in keys) for row in states])


def _values(each: Pulled) -> str:
    """The setting of the lever, in words."""
    words = [
        f"{VARIABLES[name].label} {with_unit(value, VARIABLES[name].kind, 3)}" for name, value in each.values.items()
    ]
    if each.lever.follows:
        ratios = [(at.relief_pressure - at.tank_pressure) / (at.load_pressure - at.tank_pressure) for at in each.points]
        words.append(f"relief {min(ratios):.2f} to {max(ratios):.2f} times the load")
    if each.lever.is_driven:
        words.append("motor")
    if each.soft and each.soft.chamber:
        gauge = each.soft.chamber.precharge_pressure - each.points[0].oil.reference_pressure
        words.append(f"chamber at {with_unit(gauge, GAUGE_PRESSURE, 3)}")
    return ", ".join(words)


def _points(system: System, found: Sequence[Pulled]) -> Table:
    """A row for each lever and load."""
    rows = [(each, k) for each in found for k in range(len(LOAD_SHARES))]
    reference = float(found[0].points[0].oil.reference_pressure)

    def column(values: Sequence[float], kind: Kind, label: str) -> Column:
        return Column(np.array(values, float), kind, label)

    columns = {
        "lever": Column(np.array([each.lever.name for each, _ in rows]), None, "lever"),
        "load_pressure_Pa": column([e.points[k].load_pressure - reference for e, k in rows], GAUGE_PRESSURE, "load"),
        "relief_pressure_Pa": column(
            [e.points[k].relief_pressure - reference for e, k in rows], GAUGE_PRESSURE, "relief setting"
        ),
        "closed_loss_W": column([valve_loss(e.closed[k]) for e, k in rows], MEAN_POWER, "loss, closed form"),
    }
    if found[0].real:
        columns |= {
            "stiff_loss_W": column([simulated_loss(e.stiff[k]) for e, k in rows], MEAN_POWER, "simulated, stiff oil"),
            "loss_W": column([simulated_loss(e.real[k]) for e, k in rows], MEAN_POWER, "simulated"),
        }
    columns["limit_W"] = column([limit_loss(e.closed[k]) for e, k in rows], MEAN_POWER, "lossless limit")
    return Table(title="Levers at each load", columns=columns)


def _chart(table: Table) -> Chart:
    values = ("loss_W" if "loss_W" in table.columns else "closed_loss_W", "limit_W")
    bars = Bars(names="lever", values=values, label="power lost", colours=(Colour.INLET, Colour.TANK))
    return Chart(
        name="watts",
        caption="Mean power lost over three load pressures with each lever, and the limit of transitions that lose "
        "nothing.",
        table="levers",
        panels=(bars,),
    )


def _findings(table: Table, best: int) -> Iterator[Finding]:
    simulated = "loss_W" in table.columns
    losses = table["loss_W"] if simulated else table["closed_loss_W"]
    yield Finding(
        text=f"Of {with_unit(float(losses[0]), MEAN_POWER)} on the mean over the loads, {table['lever'][best]} leaves "
        f"{with_unit(float(losses[best]), MEAN_POWER)}; with transitions that lose nothing "
        f"{with_unit(float(table['limit_W'][0]), MEAN_POWER)} would be left of the valve as it is."
    )
    if not simulated:
        return
    apart = np.abs(table["difference"])
    for row in np.flatnonzero(~(apart <= CONFIRMED)):
        yield Finding(
            title="Not confirmed",
            grade=Grade.WARNING,
            text=f"{table['lever'][row]}: simulation and closed form differ by {percent(float(apart[row]))}.",
            remedy="Rely on the simulated loss; it need not be the least.",
        )
    if not np.all(table["residual"] <= BALANCED):
        yield Finding(title="Not balanced", grade=Grade.BAD, text="A balance of energy or mass does not close.",
                      remedy="Lower run.relative_tolerance.")  # fmt: skip
