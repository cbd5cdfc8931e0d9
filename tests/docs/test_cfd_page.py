"""Numbers that docs/models/cfd.md spells out, from the studies that are kept."""

import re
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import brentq

import vvdp
from vvdp.cfd.kept import KeptStudy, kept_studies, kept_study
from vvdp.cfd.period_result import Ramps, fit_ramps
from vvdp.cfd.refinement import grid_convergence
from vvdp.evaluation.bench import rotary_bench
from vvdp.fitting.drop import fit_centre, fit_nozzle
from vvdp.fitting.fitted import Host, settings
from vvdp.fitting.jet import jet_law
from vvdp.fluid.oil import dynamic_viscosity
from vvdp.numerics.least_squares import Fit, fit
from vvdp.numerics.power_laws import drop_laws
from vvdp.numerics.square_law import SquareLaw, square_law
from vvdp.systems.system import load_system
from vvdp.valve.condition import Condition
from vvdp.valve.flow_map import averaged_spool_speed
from vvdp.valve.torque import equilibrium_speed, pwm_frequency

TEXT = (Path(__file__).parents[2] / "docs" / "models" / "cfd.md").read_text("utf-8")
PAGE = " ".join(TEXT.split())

Q40 = 40.0 / 60e3


def shares(study: KeptStudy, row: int) -> str:
    return " / ".join(f"{100.0 * study[f'split_{k}'][row]:.1f}" for k in (1, 2, 3)) + " %"


def cells(study: KeptStudy, row: int) -> str:
    return f"{study['cells'][row]:,.0f}".replace(",", " ")


def arms() -> Iterator[str]:
    study = kept_study("rail-arm")
    for k in range(study.rows):
        arm, drop = 1e3 * study["nozzle_arm_m"][k], 1e-5 * study["pressure_drop_Pa"][k]
        yield f"| {arm:.1f} mm | {cells(study, k)} | {drop:.2f} bar |"


def designs() -> Iterator[str]:
    study = kept_study("rail-designs")
    for k in range(study.rows):
        change = f"{100.0 * study['drop_change'][k]:+.0f} %" if k else ""
        force = f"{study['radial_force_N'][k]:.2f} N"
        yield f"| {1e-5 * study['pressure_drop_Pa'][k]:.2f} bar | {change} |".replace("  ", " ")
        yield f"| {shares(study, k)} |"
        yield f"| {force} |"


def openings() -> Iterator[str]:
    study = kept_study("openings")
    angles = np.degrees(study["spool_angle_rad"])
    for k in range(1, study.rows):
        way = "closing" if angles[k] > 0.0 else "opening"
        effective = f"{study['opening_effective'][k]:.3f} ({100.0 * study['difference'][k]:+.0f} %)"
        torques = f"{study['torque_N_m'][k]:.3f} N m | {study['torque_law_N_m'][k]:.3f} N m"
        yield f"| {abs(angles[k]):.4g}°, {way} | {study['opening_formula'][k]:.3f} | {effective} | {torques} |"
    closing, opening = (100.0 * study["difference"][k::2].mean() for k in (1, 2))
    yield f"is {-closing:.0f} % below the formula while closing and {opening:.0f} % above it while opening"
    factors = [1.0 + 0.01 * each for each in (closing, opening)]
    yield f"the effective opening is {factors[0]:.2f} a while closing and {factors[1]:.2f} a while opening"
    yield f"in the mean it is {-0.5 * (closing + opening):.0f} % below"


def nozzles() -> Iterator[str]:
    """The same with the whole nozzle, and the laws of the torque beside each other."""
    studies = tuple(map(kept_study, ("openings", "openings-nozzles")))
    whole = studies[1]
    angles = np.degrees(whole["spool_angle_rad"])
    for k in range(whole.rows):
        way = f"{abs(angles[k]):.4g}°, {'closing' if angles[k] > 0.0 else 'opening'}" if angles[k] else "0"
        effective, torques = ([study[key][k] for study in studies] for key in ("opening_effective", "torque_N_m"))
        shares = f"{effective[0]:.3f} | {effective[1]:.3f}" if k else "1 | 1"
        yield f"| {way} | {shares} | {torques[0]:.4f} N m | {torques[1]:.4f} N m |"
    for study, length in zip(studies, ("2.5 mm", "9.7 mm"), strict=True):
        law, power, narrow = torque_laws(study)
        yield (
            f"| {length} | {told(law, 1)} | {told(law, 2)} | {misfit(law)} | {told(power, 1)} | {told(power, 2)} | "
            f"{misfit(power)} | {told(narrow, 1)} | {misfit(narrow)} |"
        )
    opening = whole["torque_N_m"][2::2] / whole["torque_law_N_m"][2::2]
    both = np.stack([study["torque_N_m"] / study["torque_law_N_m"] - 1.0 for study in studies])[:, 1::2]
    yield f"the torque is within {100.0 * np.abs(both).max():.0f} % of the law of the system with either length"
    yield f"{100.0 * opening.min():.0f} to {100.0 * opening.max():.0f} % of the law's"
    means = [mean_laws(study) for study in studies]
    exponents, asymmetries = ([told(pair[place], 0) for pair in means] for place in (0, 1))
    yield f"$s$ = {exponents[0]} and $\\varepsilon_j$ = {asymmetries[0]} with 2.5 mm"
    yield f"$s$ = {exponents[1]} and $\\varepsilon_j$ = {asymmetries[1]} with 9.7 mm"
    found = [pair[1].coefficients[0] for pair in means] + [torque_laws(each)[0].coefficients[2] for each in studies]
    yield f"The asymmetry is {min(found):.2f} to {max(found):.2f} instead of 0.85"
    misses = [each["torque_N_m"] / each["torque_N_m"][0] * each["opening_effective"] - 1.0 for each in studies]
    yield f"$T = T_0/a_{{eff}}$, to {100.0 * max(np.abs(each[1::2]).max() for each in misses):.0f} %"


def mean_laws(study: KeptStudy) -> tuple[Fit, Fit]:
    """Exponent and asymmetry from means and differences of both ways, as `vvdp cfd openings` fits them."""
    a, torque = study["opening_formula"][1::2], study["torque_N_m"]
    closing, opening = torque[1::2], torque[2::2]
    exponent = fit([-np.log(a)], np.log(0.5 * (closing + opening) / torque[0]))
    return exponent, fit([1.0 - a], (closing - opening) / (closing + opening))


def torque_laws(study: KeptStudy) -> tuple[Fit, Fit, Fit]:
    """The law of the system, a power for either way, and closing nozzles over their effective opening."""
    a, T, side = study["opening_formula"], study["torque_N_m"], np.sign(study["spool_angle_rad"])
    power = fit([np.ones_like(a), -np.log(a), -side * np.log(a)], np.log(T))
    closes = side >= 0.0
    narrow = fit([np.ones(int(closes.sum())), -np.log(study["opening_effective"][closes])], np.log(T[closes]))
    return jet_law(a, T, side), power, narrow


def misfit(found: Fit) -> str:
    return f"{100.0 * np.abs(found.residuals).max():.1f} %"


def told(found: Fit, place: int) -> str:
    return f"{found.coefficients[place]:.2f} ± {found.half_widths[place]:.2f}"


def periods() -> Iterator[str]:
    still, slow, fast = (kept_study(name) for name in ("openings", "period-slow", "period"))
    for k, angle in enumerate(still["spool_angle_rad"][1:], 1):
        way = "closing" if angle > 0.0 else "opening"
        found = [
            [np.interp(angle, each["spool_angle_rad"], each[key]) for each in (slow, fast)]
            for key in ("opening_effective", "torque_N_m")
        ]
        openings = [still["opening_formula"][k], still["opening_effective"][k], *found[0]]
        told = " | ".join([*(f"{each:.3f}" for each in openings), *(f"{each:.3f} N m" for each in found[1])])
        yield f"| {abs(np.degrees(angle)):.4g}°, {way} | {told} |"
    yield from (f"| {' | '.join(row)} |" for row in zip(*(_period_column(each) for each in (slow, fast)), strict=True))
    yield from _missing_torques(still, slow, fast)
    closing, opening = (each.coefficients[0] for each in _factors(fast))
    yield f"factors {closing:.3f} while closing and {opening:.3f} while opening"


def _missing_torques(still: KeptStudy, slow: KeptStudy, fast: KeptStudy) -> Iterator[str]:
    """What the turning spool has less than one at rest, and than the law."""
    angle, torque = still["spool_angle_rad"][1:], still["torque_N_m"][1:]
    flow, turning = (np.interp(angle, slow["spool_angle_rad"], slow[key]) for key in ("flow_m3_s", "torque_N_m"))
    change = 100.0 * (turning / (torque * (flow / still["flow_m3_s"][1:]) ** 2) - 1.0)
    yield f"{-change[1::2].max():.0f} to {-change[1::2].min():.0f} % below that of the spools at rest"
    yield f"while closing {change[::2].min():.0f} to {change[::2].max():.0f} % above"
    late, whole = (np.interp(np.radians(at), slow["spool_angle_rad"], slow["torque_N_m"]) for at in (-12.0, 0.0))
    yield f"it is {late:.3f} N m, and {whole:.3f} N m only at 0°"
    turned = (876.0 * 12.7e-3**2 * speed * each["flow_m3_s"].mean() for each, speed in ((fast, 48.0), (slow, 4.8)))
    swirls = [np.pi * each for each in turned]
    less = [(each["torque_law_N_m"] - each["torque_N_m"]).mean() for each in (fast, slow)]
    yield f"{swirls[0]:.4f} of the {less[0]:.4f} N m that are missing in the mean"
    yield f"at 144 rpm {swirls[1]:.4f} of {less[1]:.4f} N m"
    off = np.abs(fast["opening_effective"] - fast["opening_formula"]).max()
    yield f"up to {100.0 * off:.0f} % of the open area off"


def _factors(study: KeptStudy) -> Ramps:
    return fit_ramps(study["spool_angle_rad"], study["opening_formula"], study["opening_effective"])


def _period_column(study: KeptStudy) -> Iterator[str]:
    """What a period comes to, in the order of the page's table."""
    angle, flow = study["spool_angle_rad"], study["flow_m3_s"]
    yield f"{1e6 * np.interp(0.0, angle, flow) / np.sqrt(2.0 * 3.563e5 / 876.0):.1f} mm²"
    yield from (f"{each.coefficients[0]:.3f} ± {each.half_widths[0]:.3f}" for each in _factors(study))
    formula, effective = study["opening_formula"], study["opening_effective"]
    yield f"{100.0 * (effective.mean() / formula.mean() - 1.0):.1f} %"
    middles = [(angle * share).sum() / share.sum() for share in (effective, formula)]
    yield f"{np.degrees(middles[0] - middles[1]):.2f}°"
    yield from (f"{study[key].mean():.4f} N m" for key in ("torque_N_m", "torque_law_N_m"))
    yield f"{100.0 * abs(study['flow_out_m3_s'] - flow).mean() / flow.mean():.2f} %"


def grids() -> Iterator[str]:
    for name, words in PARTS.items():
        study = kept_study(name)
        quantities = {"pressure_drop_Pa": (1e-5, "bar", 2)}
        quantities |= dict.fromkeys(("torque_N_m", "torque_momentum_N_m"), (1.0, "N m", 4))
        for key in (key for key in quantities if key in study.columns):
            scale, unit, digits = quantities[key]
            found = grid_convergence(tuple(study["cell_size_m"][::-1]), tuple(study[key][::-1]))
            values = " / ".join(f"{scale * value:.{digits}f}" for value in study[key])
            many = " / ".join(cells(study, k) for k in range(study.rows))
            order = f"{found.order:.1f}" if found.order > 0.0 else "none"
            order = f"{order} | {100.0 * found.band:.1f} %" if found.is_monotone else "swings |"
            yield f"| {words[key]} | {many} | {values} {unit} | {order} | {100.0 * found.spread:.1f} % |"


PARTS = {
    "rail-grids": {"pressure_drop_Pa": "rail (a), drop"},
    "rail-laminar-grids": {"pressure_drop_Pa": "rail (a), laminar, drop"},
    "rail-final-grids": {"pressure_drop_Pa": "final rail, drop"},
    "centre-grids": {"pressure_drop_Pa": "centre section, total drop", "torque_N_m": "its torque"},
    "turbine-grids": {
        "pressure_drop_Pa": "turbine, drop",
        "torque_N_m": "its torque",
        "torque_momentum_N_m": "the same by angular momentum",
    },
}


def turbines() -> Iterator[str]:
    study = kept_study("turbine-lengths")
    for arm in dict.fromkeys(study["outlet_arm_m"].tolist()):
        mine = study["outlet_arm_m"] == arm
        speeds, torques = study["speed_rad_s"][mine], study["torque_N_m"][mine]
        at_rest, slope = fit([np.ones_like(speeds), speeds], torques).coefficients
        drop, behind = study["turbine_drop_Pa"][mine][0], study["collector_drop_Pa"][mine][0]
        flow = study["flow_m3_s"][mine][0]
        area = 876.0 * 12.7e-3 * flow**2 / at_rest
        coefficient = flow / 46.8e-6 / np.sqrt(2.0 * drop / 876.0)
        yield (
            f"| {1e3 * arm:.1f} mm | {study['outlet_entry_taper'][mine][0]:.2f} | {at_rest:.4f} N m | "
            f"{1e6 * area:.1f} mm² | {1e4 * slope:.2f}e-4 N m s | {1e-5 * drop:.2f} bar | {coefficient:.3f} | "
            f"{1e-5 * behind:.2f} bar |"
        )


def laws() -> Iterator[str]:
    study = kept_study("rail-flows")
    found = drop_laws(study["flow_m3_s"], study["pressure_drop_Pa"])
    c, half = found.orifice.coefficients[0], found.orifice.half_widths[0]
    middle, low, high = (np.sqrt(0.5 * 876.0 / each) / 36.5e-6 for each in (c, c + half, c - half))
    yield f"$C_d$ = {middle:.3f} ({low:.3f} to {high:.3f}; published 0.61)"
    yield f"$m$ = {found.power.coefficients[1]:.2f} ± {found.power.half_widths[1]:.2f}"
    misfits = [1e-5 * np.abs(each.residuals).max() for each in (found.orifice, found.two_term)]
    yield f"misfit of the orifice {misfits[0]:.2f} bar, of the two terms {misfits[1]:.2f} bar"


def centre() -> Iterator[str]:
    study = kept_study("centre-flows")
    for k in range(study.rows):
        static, total = 1e-5 * study["static_drop_Pa"][k], 1e-5 * study["total_drop_Pa"][k]
        yield (
            f"| {1e3 * study['diameter_m'][k]:.2f} mm | {60e3 * study['flow_m3_s'][k]:.0f} lpm | {total:.3f} bar | "
            f"{static:.3f} bar | {1e-5 * study['static_drop_law_Pa'][k]:.3f} bar | {study['torque_N_m'][k]:.4f} N m | "
            f"{study['torque_law_N_m'][k]:.4f} N m |"
        )
    columns = {"flow": study["flow_m3_s"], "diameter": study["diameter_m"]}
    for key, words in (("static_drop_Pa", "static"), ("total_drop_Pa", "total")):
        found = fit_centre({**columns, "pressure_drop": study[key]}, None).coefficients
        m, n = (found[name].interval for name in ("exponent", "diameter_exponent"))
        told = (f"${name}$ = {each.value:.2f} ± {each.high - each.value:.2f}" for name, each in (("m", m), ("n", n)))
        yield f"{words} drop: {', '.join(told)}"
    finer = kept_study("centre-flows-medium")
    first, *others, last = (f"{1e-5 * drop:.3f}" for drop in finer["static_drop_Pa"])
    yield f"the static drops are {', '.join([first, *others])} and {last} bar"
    totals = kept_study("centre-grids")["pressure_drop_Pa"]
    swings = [100.0 * (high - low) / finer["static_drop_Pa"][1] for high, low in (totals[:2], totals[:0:-1])]
    yield f"those are {swings[0]:.0f} % and {swings[1]:.0f} %"
    m = np.polyfit(np.log(finer["flow_m3_s"]), np.log(finer["static_drop_Pa"]), 1)[0]
    logs = np.log(finer["flow_m3_s"]), np.log(finer["static_drop_Pa"])
    yield f"$m$ = {m:.2f} ± {fit([np.ones_like(logs[0]), logs[0]], logs[1]).half_widths[1]:.2f}"


def two_arms() -> Iterator[str]:
    study = kept_study("centre-arms")
    Q = study["flow_m3_s"]
    for arm in dict.fromkeys(study["nozzle_arm_m"].tolist()):
        rows = study["nozzle_arm_m"] == arm
        law = 876.0 * 12.7e-3 / 36.5e-6 * Q[rows] ** 2
        ratio = 1.0 / float(fit([law], study["torque_N_m"][rows]).coefficients[0])
        valve = load_system("prototype-constant-load", [f"valve.inlet_area_ratio={ratio}"]).case.params.valve
        frequency = pwm_frequency(equilibrium_speed(Q40, 876.0, 0.0387, valve), valve)
        torque = study["torque_N_m"][rows & np.isclose(Q, Q40)][0]
        yield f"| {1e3 * arm:.1f} mm | {torque:.4f} N m | {ratio:.3f} | {frequency:.1f} Hz |"


def flows() -> Iterator[str]:
    study = kept_study("turbine-flows")
    Q, w = study["flow_m3_s"], study["speed_rad_s"]
    for k in range(study.rows):
        drop, behind = 1e-5 * study["turbine_drop_Pa"][k], 1e-5 * study["collector_drop_Pa"][k]
        torques = f"{study['torque_N_m'][k]:.4f} N m | {study['torque_law_N_m'][k]:.4f} N m"
        at = f"| {60e3 * Q[k]:.0f} lpm | {w[k] * 30.0 / np.pi:.0f} rpm"
        yield f"{at} | {torques} | {drop:.3f} bar | {behind:.3f} bar |"
    c, b = fit([Q**2, -Q * w], study["torque_N_m"]).coefficients
    errors = fit([Q**2, -Q * w], study["torque_N_m"]).half_widths
    area, error = 876.0 * 12.7e-3 / c, 876.0 * 12.7e-3 / c * errors[0] / c
    yield f"effective area of {1e6 * area:.1f} ± {1e6 * error:.1f} mm²"
    yield f"{b / (876.0 * 12.7e-3**2):.2f} ± {errors[1] / (876.0 * 12.7e-3**2):.2f} times"
    yield f"the discharge coefficient is {turbine_coefficient():.3f} (published 0.677)"
    yield f"the law of both leaves {1e3 * np.abs(fit([Q**2, -Q * w], study['torque_N_m']).residuals).max():.1f} mN m"
    still = w == 0.0
    spreads = [np.ptp(study[key][still] / Q[still] ** 2 * Q40**2) for key in ("torque_N_m", "turbine_drop_Pa")]
    middles = [study[key][still][1] for key in ("torque_N_m", "turbine_drop_Pa")]
    torques, drops = (100.0 * spread / middle for spread, middle in zip(spreads, middles, strict=True))
    yield f"differs by {torques:.1f} %, the drop by {drops:.1f} %"
    other, ratio = fit([Q**2, -Q * w], study["torque_momentum_N_m"]), 876.0 * 12.7e-3
    (c, b), errors = other.coefficients, other.half_widths
    told = f"{1e6 * ratio / c:.1f} ± {1e6 * ratio / c * errors[0] / c:.1f} mm²"
    yield f"give {told} and {b / (ratio * 12.7e-3):.2f} ± {errors[1] / (ratio * 12.7e-3):.2f} times"
    apart = 100.0 * np.abs(study["torque_momentum_N_m"] / study["torque_N_m"] - 1.0)
    yield f"the torques differ from those by {apart.min():.0f} to {apart.max():.0f} %"
    lengths = kept_study("turbine-lengths")
    same = (lengths["outlet_entry_taper"] == 1.08) & (lengths["speed_rad_s"] == 0.0)
    arms, torques = (lengths[key][same] for key in ("outlet_arm_m", "torque_N_m"))
    less = 1.0 - np.interp(8.6e-3, arms, torques) / study["torque_N_m"][still][1]
    yield f"8.6 mm have {100.0 * less:.0f} % less torque than here"
    finer = kept_study("turbine-grids")["torque_N_m"][-1]
    area = 1e6 * 876.0 * 12.7e-3 * Q40**2 / finer
    short = 100.0 * (1.0 - area / 61.8)
    grids = kept_study("turbine-grids")
    found = grid_convergence(*(tuple(grids[key][::-1]) for key in ("cell_size_m", "torque_momentum_N_m")))
    last = float(grids["torque_momentum_N_m"][-1])
    areas = [1e6 * 876.0 * 12.7e-3 * Q40**2 / each for each in (last, found.extrapolated)]
    off = 100.0 * (1.0 - areas[0] / 61.8)
    yield f"{last:.4f} N m and {areas[0]:.1f} mm², {off:.1f} % below it, and {areas[1]:.1f} mm² for"
    yield f"{finer:.4f} N m at rest, an effective area of {area:.1f} mm², {short:.1f} % below the published one"


def turbine_coefficient() -> float:
    """The discharge coefficient of the turbine with its spool at rest, over all flows."""
    study = kept_study("turbine-flows")
    still = study["speed_rad_s"] == 0.0
    square = study["flow_m3_s"][still] ** 2
    return float(1.0 / 46.8e-6 / np.sqrt(2.0 / 876.0 * (square @ study["turbine_drop_Pa"][still]) / (square @ square)))


def million() -> Iterator[str]:
    study = kept_study("rail-million")
    mesh, solver = (f"{study[key][0] / 2**30:.1f} GiB" for key in ("mesh_memory_B", "solver_memory_B"))
    yield f"gives the rail {study['cells'][0]:,.0f} cells".replace(",", " ")
    yield f"its mesh took {mesh} and {study['mesh_time_s'][0]:.0f} s of processor time"
    yield f"the solver {solver}, and {study['iteration_time_s'][0]:.1f} s an iteration on either core"


def computed_laws() -> tuple[str, ...]:
    """What the kept studies make of the valve's laws, as settings of a system."""
    loaded = load_system("prototype-constant-load")
    bench = rotary_bench(loaded, "fit")
    host = Host("prototype", "valve", bench.valve, bench.oil, 313.15, bench.load_pressure, bench.tank_pressure)
    rail, centre_section, turbine = (kept_study(name) for name in ("rail-flows", "centre-flows", "turbine-flows"))
    drops = {"flow": centre_section["flow_m3_s"], "diameter": centre_section["diameter_m"]}
    found = (
        (fit_nozzle({"flow": rail["flow_m3_s"], "pressure_drop": rail["pressure_drop_Pa"]}, host), "rail-flows.csv"),
        (fit_centre({**drops, "pressure_drop": centre_section["static_drop_Pa"]}, host), "centre-flows.csv"),
    )
    Q, w = turbine["flow_m3_s"], turbine["speed_rad_s"]
    area = 876.0 * 12.7e-3 / fit([Q**2, -Q * w], turbine["torque_N_m"]).coefficients[0]
    coefficient = turbine_coefficient()
    jets = fit([centre_section["torque_law_N_m"]], centre_section["torque_N_m"]).coefficients[0]
    return (
        *(text for each, name in found for text in settings(each, Path(name), host)),
        f"valve.inlet_area_ratio={1.0 / jets}",
        f"valve.outlet_effective_area={1e6 * area} mm^2",
        f"valve.outlet_discharge_coefficient={coefficient}",
    )


def frequencies() -> Iterator[str]:
    """Of the ideal machine at 40 lpm, with the published laws and with those that were computed."""
    at = Condition(flow=Q40, load_pressure=1.01e7, relief_pressure=1.21e7, tank_pressure=101325.0, density=876.0)
    jets = ("valve.jet_exponent=0.65", "valve.jet_asymmetry=0.85")
    found = []
    for laws in ((), computed_laws()):
        valve = load_system("prototype-constant-load", [*jets, *laws]).case.params.valve
        full = pwm_frequency(equilibrium_speed(Q40, 876.0, 0.0387, valve), valve)
        switching = pwm_frequency(averaged_spool_speed(0.5, at, 0.0387, valve), valve)
        found.append(f"{full:.1f} Hz fully open and {switching:.1f} Hz switching at duty ratio 0.5")
    yield f"the published laws give {found[0]}"
    yield f"those that were computed {found[1]}"
    whole = kept_study("openings-nozzles")
    means, logs = mean_laws(whole)[0].coefficients[0], torque_laws(whole)[0].coefficients[1]

    def switching_at(s: float, temperature: float = 313.15) -> float:
        system = load_system("prototype-constant-load", [f"valve.jet_exponent={s}"])
        oil, valve = system.case.params.oil, system.case.params.valve
        return pwm_frequency(averaged_spool_speed(0.5, at, float(dynamic_viscosity(temperature, oil)), valve), valve)

    def reaches(frequency: float, s: float) -> float:
        return float(brentq(lambda T: switching_at(s, T) - frequency, 305.0, 318.0)) - 273.15

    yield f"by their means, {means:.2f}, {switching_at(means):.1f} Hz"
    yield f"by logarithms, {logs:.2f}, {switching_at(logs):.1f} Hz"
    yield f"the system's 0.65 {switching_at(0.65):.1f} Hz; jets as narrow as the opening, 1, {switching_at(1.0):.1f} Hz"
    yield f"a kelvin is {100.0 * (switching_at(0.65, 314.15) / switching_at(0.65) - 1.0):.0f} %"
    bands = [f"between {reaches(70.4, s):.1f} and {reaches(82.0, s):.1f} °C" for s in (0.65, 1.0)]
    yield f"an exponent of 0.65 has 70.4 to 82 Hz {bands[0]}, 1 {bands[1]}"


def distances() -> Iterator[str]:
    """y+ of the grids of the rail, and of each approach at the largest flow."""
    for name in ("rail-grids", *models()):
        study = kept_study(name)
        for k in range(study.rows):
            if "approach" in study.columns and study["flow_m3_s"][k] != study["flow_m3_s"].max():
                continue
            least, mean, largest = (f"{study[f'y_plus_{end}'][k]:.2g}" for end in ("least", "mean", "largest"))
            head = study["approach"][k] if "approach" in study.columns else cells(study, k)
            yield f"| {head} | {least} | {mean} | {largest} | {study['residual_share'][k]:.2g} |"


def models() -> tuple[str, ...]:
    return tuple(name for name in kept_studies() if name.endswith("-models"))


KEYS = ("pressure_drop_Pa", "static_drop_Pa", "torque_N_m")


def approach_laws(study: KeptStudy) -> dict[str, dict[str, SquareLaw]]:
    """The laws of each approach by name and column."""
    names = dict.fromkeys(study["approach"].tolist())
    keys = [key for key in KEYS if key in study.columns]
    return {
        name: {
            key: square_law(*(study[each][study["approach"] == name] for each in ("flow_m3_s", key))) for key in keys
        }
        for name in names
    }


def effects() -> Iterator[str]:
    """Of each part the laws by each approach over those of the first, and their exponents."""
    for name in models():
        laws = approach_laws(kept_study(name))
        first = next(iter(laws.values()))
        for approach, found in laws.items():
            shown = [
                f"{found[key].coefficient / first[key].coefficient:.3f} | {found[key].exponent:.2f}"
                for key in (KEYS[:1] if name.startswith("rail") else KEYS if "centre" in name else KEYS[::2])
            ]
            yield f"| {approach} | {' | '.join(shown)} |"
    drops = [each[KEYS[0]].coefficient for each in approach_laws(kept_study("rail-models")).values()]
    coefficients = np.array([0.6230 * np.sqrt(drops[0] / each) for each in drops])
    yield f"$C_d$ is {coefficients.min():.3f} to {coefficients.max():.3f}"
    every = {name: approach_laws(kept_study(name)) for name in models()}
    off = {
        key: max(
            abs(laws[each][key].coefficient / laws["k-epsilon"][key].coefficient - 1.0)
            for laws in every.values()
            for each in ("k-omega SST", "laminar")
            if key in laws[each]
        )
        for key in KEYS
    }
    drop, torque = 100.0 * max(off[KEYS[0]], off[KEYS[1]]), 100.0 * off[KEYS[2]]
    yield f"within {drop:.0f} % of k-epsilon in each drop and {torque:.0f} % in each torque"
    for name, key, words in (
        ("rail", KEYS[0], "the drop of the rail {:.0f} % larger"),
        ("centre", KEYS[1], "the static drop of the centre section {:.0f} % smaller"),
        ("turbine", KEYS[2], "the torque of the turbine {:.0f} % smaller"),
    ):
        laws = every[f"{name}-models"]
        share = laws["k-epsilon, first order"][key].coefficient / laws["k-epsilon"][key].coefficient
        yield words.format(100.0 * abs(share - 1.0))
    fine, big = kept_study("rail-grids"), kept_study("rail-million")
    laminar = kept_study("rail-laminar-grids")["pressure_drop_Pa"]
    yield f"grows by {100.0 * (laminar[2] / laminar[0] - 1.0):.1f} % from R/8 to R/16"
    yield f"an extrapolated {1e-5 * rail_extrapolated():.1f} bar"
    seconds = big["mesh_time_s"][0] + fine["iterations"][-1] * big["iteration_time_s"][0]
    yield f"{seconds / 60.0:.0f} min on two cores"


def rail_extrapolated() -> float:
    """Drop of the rail on cells of no size [Pa]."""
    study = kept_study("rail-grids")
    sizes, drops = (tuple(study[key][::-1]) for key in ("cell_size_m", "pressure_drop_Pa"))
    return grid_convergence(sizes, drops).extrapolated


def headlines() -> Iterator[str]:
    """Frequency and efficiency of the prototype, its published laws scaled by the ratios of each approach."""
    found = {name.removesuffix("-models"): approach_laws(kept_study(name)) for name in models()}

    def ratio(part: str, approach: str, key: str) -> float:
        laws = found[part]
        return laws[approach][key].coefficient / next(iter(laws.values()))[key].coefficient

    ranges: list[tuple[float, float]] = []
    for approach in found["rail"]:
        values = {
            "nozzle_discharge_coefficient": 0.61 / ratio("rail", approach, KEYS[0]) ** 0.5,
            "centre_coefficient": 1.45e-6 / ratio("centre", approach, KEYS[1]),
            "inlet_area_ratio": 1.0 / ratio("centre", approach, KEYS[2]),
            "outlet_discharge_coefficient": 0.677 / ratio("turbine", approach, KEYS[0]) ** 0.5,
            "outlet_effective_area": 61.8e-6 / ratio("turbine", approach, KEYS[2]),
        }
        run = vvdp.load("prototype", valve=values).run()
        frequency, efficiency = run.summary["pwm_frequency_Hz"], run.summary["efficiency"]
        yield f"| {approach} | {frequency:.1f} Hz | {100.0 * efficiency:.1f} % |"
        ranges.append((frequency, 100.0 * efficiency))
    (low, least), (high, most) = (np.array(ranges).min(0), np.array(ranges).max(0))
    told = f"{low:.1f} to {high:.1f} Hz and {least:.1f} to {most:.1f} %"
    yield told
    coefficient = 0.61 * (kept_study("rail-grids")["pressure_drop_Pa"][0] / rail_extrapolated()) ** 0.5
    run = vvdp.load("prototype", valve={"nozzle_discharge_coefficient": coefficient}).run()
    finest = f"gives {run.summary['pwm_frequency_Hz']:.1f} Hz and {100.0 * run.summary['efficiency']:.1f} %"
    yield f"becomes {coefficient:.3f}, and the run {finest}"
    readme = " ".join((Path(__file__).parents[2] / "README.md").read_text("utf-8").split())
    assert told in readme
    assert finest in readme


def opening_torques() -> Iterator[str]:
    """Torque of opening nozzles at the flow of open ones: spools at rest by either scheme, and one that turns."""
    still, first, slow = (kept_study(name) for name in ("openings", "openings-first-order", "period-slow"))
    angle = still["spool_angle_rad"][2::2]
    flow, torque = (np.interp(angle, slow["spool_angle_rad"], slow[key]) for key in ("flow_m3_s", "torque_N_m"))
    turning = torque * (Q40 / flow) ** 2
    for k, each in enumerate(angle):
        torques = (still["torque_N_m"][2::2][k], first["torque_N_m"][2::2][k], turning[k])
        yield f"| {-np.degrees(each):.4g}° | {' | '.join(f'{value:.4f} N m' for value in torques)} |"
    missing = 100.0 * (still["torque_N_m"][2::2] - turning) / still["torque_N_m"][0]
    yield f"{missing.min():.0f} to {missing.max():.0f} % of the torque of open nozzles"
    speeds = kept_study("period-speeds")
    for each in dict.fromkeys(speeds["spool_speed_rad_s"].tolist()):
        rows = (speeds["spool_speed_rad_s"] == each) & (speeds["spool_angle_rad"] < 0.0)
        same = speeds["torque_N_m"][rows] * (Q40 / speeds["flow_m3_s"][rows]) ** 2
        yield f"| {each * 30.0 / np.pi:.0f} rpm | {' | '.join(f'{value:.4f} N m' for value in same)} |"


def sleeves() -> Iterator[str]:
    """What the bore adds to the drop of the rail."""
    study = kept_study("sleeve")
    (whole, rail), many = study["drop_Pa"], [cells(study, row) for row in (0, 1)]
    added = f"it adds {1e-5 * (whole - rail):.2f} bar to {1e-5 * rail:.2f} bar"
    yield f"({many[0]} and {many[1]} cells, kept as `sleeve`) {added}"
    yield f"So the {1e-5 * (whole - rail):.2f} bar, {100.0 * (whole / rail - 1.0):.0f} % of the drop"


ROWS = (
    arms,
    designs,
    openings,
    nozzles,
    periods,
    grids,
    turbines,
    laws,
    flows,
    centre,
    million,
    two_arms,
    frequencies,
    distances,
    effects,
    headlines,
    opening_torques,
    sleeves,
)


@pytest.mark.parametrize("rows", ROWS, ids=lambda rows: rows.__name__)
def test_rows_are_those_of_the_kept_studies(rows):
    for row in rows():
        assert row in PAGE


def test_every_study_that_is_kept_is_named():
    named = PAGE[PAGE.index("## What is kept") :]
    assert [name for name in kept_studies() if f"`{name}`" not in named] == []


def test_what_vvdp_takes_is_what_the_benchmark_found():
    table = (Path(__file__).parents[2] / "benchmarks" / "README.md").read_text("utf-8")
    share, seconds = re.search(r"vvdp itself over the bare solver \| ([\d.]+ %) of (\d+) s", table).groups()
    assert f"{share} of {seconds} s of the bare solver on the rail at `--grid 8`" in PAGE


def meshes(name):
    """Numbers of cells of a kept table, one for each of its meshes."""
    study = kept_study(name)
    return set(study["cells"].tolist()) if "cells" in study.columns else {name}


def test_tables_without_walls_are_listed_with_those_that_have_them_on_the_same_mesh():
    found = re.findall(
        r"^\| `([\w-]+)` \| (\d+) \| (\d+ in .*|none.*) \|$", TEXT.partition("### Tables without y+\n")[2], re.M
    )
    with_walls = {name for name in kept_studies() if "y_plus_mean" in kept_study(name).columns}
    assert [name for name, _, _ in found] == [name for name in kept_studies() if name not in with_walls]
    for name, count, where in found:
        own = meshes(name)
        assert len(own) == int(count), name
        shared = {other: own & meshes(other) for other in with_walls if own & meshes(other)}
        named = re.findall(r"`([\w-]+)`", where)
        assert set().union(*shared.values()) == set().union(*(shared[each] for each in named)), name
        assert len(set().union(*shared.values())) == (int(where.split()[0]) if named else 0), name


def test_repeated_tables_have_their_walls_and_settled():
    for name in ("rail-flows", "centre-grids", "turbine-grids", "rail-final-grids"):
        study = kept_study(name)
        assert (study["y_plus_least"] < study["y_plus_mean"]).all() and (
            study["y_plus_mean"] < study["y_plus_largest"]
        ).all()
        assert study["has_settled"].all() and (study["residual_share"] > 0.0).all()
