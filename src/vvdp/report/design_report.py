"""The reports of design studies: one page each, from the files that they left."""

import json
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from vvdp.base.display import fixed, number, percent, plain, unit_symbol
from vvdp.base.kinds import PRESSURE_LEVEL
from vvdp.base.units import ATMOSPHERE, in_unit
from vvdp.design.pareto import NUMBERS_OF_FRONT
from vvdp.design.problem import shown
from vvdp.design.quantities import KINDS
from vvdp.design.results import read_numbers
from vvdp.design.variables import VARIABLES
from vvdp.report.design_figures import front_figures, optimum_figures, temperature_figures, tolerance_figures, words
from vvdp.report.drawing import Drawn
from vvdp.report.html import figure, row, table, text
from vvdp.report.page import opening, write_page

SOURCE_OPTIMUM = 2.48e5
"""Full-open drop that wang2017, section 2.6, states for its optimum [Pa]."""


def write_design_report(directory: Path) -> Path:
    """Writes report.html and figures/ beside the files of an optimum and gives the path of the page.

    Raises ConfigError where the directory holds none.
    """
    found = read_numbers(directory)
    figures = tuple(optimum_figures(found))
    return written(directory, f"{found['title']}: optimum", _optimum(found, figures), figures)


def written(directory: Path, title: str, body: Iterator[str], figures: Sequence[Drawn]) -> Path:
    """Writes a page with `body` and the files of its `figures`."""
    meta = json.loads((directory / "meta.json").read_text("utf-8"))
    facts = f"{text(meta['written'][:10])} &middot; vvdp {text(meta['vvdp'])}"
    head = f'{opening(text(title))}\n<h1>{text(title)}</h1>\n<p class="facts">{facts}</p>'
    return write_page(directory, [head, *body, "</body>\n</html>"], figures)


def quantity(value: float | None, name: str, digits: int = 4) -> str:
    """A variable or quantity [SI] with its unit, as HTML."""
    kind = KINDS[name] if name in KINDS else VARIABLES[name].kind
    if value is None:
        return "&ndash;"
    if kind is PRESSURE_LEVEL:
        return text(f"{number((value - ATMOSPHERE) / 1e5, digits)} bar")
    if kind.unit == "1":
        return text(plain(value, digits))
    return text(f"{plain(in_unit(value, kind, kind.shown), digits)} {unit_symbol(kind.shown)}")


def _optimum(found: Mapping[str, Any], figures: Sequence[Drawn]) -> Iterator[str]:
    yield f'<p class="lead">{_in_words(found)}</p>'
    yield from _notices(found)
    yield from (figure(each.svg, each.name, count, text(each.caption)) for count, each in enumerate(figures, 1))
    yield '<h2 class="page">Question and bounds</h2>'
    usual = " (usual limit, as nothing of that sort was demanded; --no-usual-limits leaves it out)"
    demands = "".join(f"<li>{text(each['text'])}{usual if each['usual'] else ''}</li>" for each in found["limits"])
    demands += "".join(f"<li>{text(each)} (always demanded)</li>" for each in found["demands"])
    yield f"<p>Least {text(words(found['objective']))}, subject to</p>\n<ul>{demands}</ul>"
    yield table(
        ("variable", "before", "optimum", "from", "to", ""),
        [_variable(each) for each in found["variables"]],
        (1, 2, 3, 4),
    )
    yield (
        '<p class="small">With the spool radius go the radii of the jets and the friction area, with its square the '
        "spool's mass, and with the outlet area its effective area.</p>"
    )
    yield _points(found)
    yield "<h2>What holds the optimum</h2>"
    yield (
        "<p>From the multipliers of the solver. The change of the objective is for 1 % more of the value, which zero "
        "and a demand of the geometry do not have; a bound that is not listed has no influence.</p>"
    )
    yield table(("held by", "which is a", "objective changes by"), [_active(each) for each in found["active"]], (2,))
    yield "<h2>How sure it is</h2>"
    yield f"<p>{text(_search(found))}</p>"
    yield "<h2>Before and after</h2>"
    yield _quantities(found)
    yield (
        '<p class="small">The compressibility loss counts the PWM frequency of the fully open valve here, that of the '
        "switching valve, which is lower, in <code>vvdp valve</code> and in the comparison with the simulation. The "
        "efficiency is the load power, less leakage and compressibility, over the power put in; that of an analytic "
        "map leaves compressibility out.</p>"
    )
    if found["simulated"]:
        yield "<h2>Closed forms against simulation</h2>"
        yield _simulated(found)
        yield (
            '<p class="small">The formulas count volumes and add up an upper estimate of the losses, see the model '
            "of the rotary valve; 1 to 4 % of difference is usual, more where a warning stands above. Here they are "
            "evaluated at the mean load pressure of the simulation, above at that of the operating point.</p>"
        )


SHARES = ("efficiency", "transition_fraction")


def change(name: str, before: float, after: float) -> str:
    """From before to after: in per cent, for a share in percentage points."""
    if name in SHARES:
        return f"{100.0 * (after - before):+.1f} points"
    return percent(after / before - 1.0) if before else "&ndash;"


def _in_words(found: Mapping[str, Any]) -> str:
    name = found["objective"]
    before, after = found["objective_before"], found["objective_after"]
    demands = ", ".join(each["text"] + (" (a usual limit)" if each["usual"] else "") for each in found["limits"])
    lead = (
        f"The {words(name)} goes from {quantity(before, name)} to <b>{quantity(after, name)}</b> "
        f"({change(name, before, after)})"
        f"{', subject to ' + text(demands) if demands else ''}, analytically."
    )
    if found["simulated_means"]:
        simulated, was, now = found["simulated_means"]
        other = "" if simulated == name else f"the {text(words(simulated))} "
        lead += (
            f" Simulated, {other or 'it '}goes from {quantity(was, simulated)} to <b>{quantity(now, simulated)}</b> "
            f"({percent(now / was - 1.0) if was else '&ndash;'})."
        )
    if len(found["points"]) > 1:
        lead += f" It is the weighted mean over {len(found['points'])} operating points."
    bounds = [each["text"] for each in found["active"] if each["kind"] != "limit"]
    if bounds:
        lead += f" The result depends on {text('; '.join(bounds))}: other bounds give another optimum."
    return lead


def _notices(found: Mapping[str, Any]) -> Iterator[str]:
    if found["simulation_doubts"]:
        told = "".join(f"<p>{text(each[:1].upper() + each[1:])}.</p>" for each in found["simulation_doubts"])
        yield f'<div class="notice bad"><strong>The simulation does not bear out the optimum</strong>{told}</div>'
    if "wang2017" in found["sources"] and found["objective"] == "pressure_drop_total":
        drop = found["objective_after"]
        near = (
            "This optimum is that value"
            if abs(drop / SOURCE_OPTIMUM - 1.0) < 0.012
            else "This optimum is another value"
        )
        yield (
            '<div class="notice"><strong>The 2.48 bar of wang2017 depend on bounds that it does not state</strong>'
            "<p>The source gives 6.61 bar for the prototype and 2.48 bar for its optimum, without the bounds of its "
            "variables. With the prototype's radius and clearance the best is 6.63 bar at 72 Hz; 2.48 bar follow, for "
            "example, at 72 Hz with a clearance of at most 22.5 µm and no limit on the transition fraction, which is "
            f"then 0.50. {near}, within the bounds listed below.</p></div>"
        )
    if found["doubts"]:
        told = "".join(f"<p>{text(each[:1].upper() + each[1:])}.</p>" for each in found["doubts"])
        yield f'<div class="notice"><strong>What is in doubt at the optimum</strong>{told}</div>'
    if not found["finished"]:
        yield (
            '<div class="notice"><strong>The search was interrupted</strong>'
            "<p>This is the best design that was found until then; a better one may exist.</p></div>"
        )


def _variable(each: Mapping[str, Any]) -> str:
    name = each["name"]
    cells = [quantity(each[k], name) for k in ("before", "after", "low", "high")]
    given = [end for end, word in (("low", "from"), ("high", "to")) if each[f"{end}_given"]]
    whose = {2: "asked for", 1: f"{'lower' if given == ['low'] else 'upper'} one asked for", 0: "usual bounds"}
    return row([text(each["words"]), *cells, whose[len(given)]], ("", "n", "n", "n", "n", "q"))


def _points(found: Mapping[str, Any]) -> str:
    lines = []
    for each in found["points"]:
        cells = [
            number(each["weight"], 3),
            f"{fixed(6e4 * each['flow_m3_s'], 2)} lpm",
            f"{fixed(each['temperature_K'] - 273.15, 1)} °C",
            number(each["duty_ratio"], 3),
            f"{fixed((each['load_pressure_Pa'] - ATMOSPHERE) / 1e5, 1)} bar",
            f"{fixed((each['relief_pressure_Pa'] - ATMOSPHERE) / 1e5, 1)} bar",
        ]
        lines.append(row(cells, ("n",) * 6))
    return table(("weight", "pump flow", "oil", "duty ratio", "load", "relief setting"), lines, range(6))


def _active(each: Mapping[str, Any]) -> str:
    effect = "&ndash;" if each["elasticity"] is None else f"{fixed(each['elasticity'], 3)} %"
    return row([text(each["text"]), text(each["kind"]), effect], ("", "q", "n"))


def _search(found: Mapping[str, Any]) -> str:
    s = found["search"]
    told = (
        f"{s['converged']} of {s['starts']} random starts ended in a design that meets all demands, {s['agreeing']} of "
        "them in this one."
    )
    others = len(s["worse_optima"])
    if others:
        name = found["objective"]
        told += f" There are {others} worse local optima: " + ", ".join(
            shown(value, KINDS[name]) for value in s["worse_optima"][:5]
        )
        told += "." if others <= 5 else " and more."
    if s["global_objective"] is not None:
        apart = s["global_objective"] / found["objective_after"] - 1.0
        told += (
            f" A differential evolution over {s['global_evaluations']} designs, which uses no gradients, came by "
            f"itself to within {percent(apart, 4)} of it."
        )
    return told


def _quantities(found: Mapping[str, Any]) -> str:
    from vvdp.design.quantities import key

    lines = []
    for name, kind in KINDS.items():
        before, after = (found[f"mean_{when}"][key(name, kind)] for when in ("before", "after"))
        cells = [text(words(name)), quantity(before, name), quantity(after, name), change(name, before, after)]
        lines.append(row(cells, ("", "n", "n", "n")))
    return table(("analytic", "before", "optimum", "change"), lines, (1, 2, 3))


COMPARED = (
    ("PWM frequency, averaged [Hz]", ("pwm_frequency_Hz",), ("analytic_pwm_frequency_Hz",), 1.0),
    (
        "throttling and relief [W]",
        ("loss_full_open_W", "loss_transition_W"),
        ("analytic_loss_full_open_W", "analytic_loss_transition_W"),
        1.0,
    ),
    ("leakage [W]", ("loss_valve_leakage_W",), ("analytic_loss_leakage_W",), 1.0),
    ("total loss [W]", ("loss_total_W",), ("analytic_loss_total_W",), 1.0),
    ("flow to the load [lpm]", ("mean_load_flow_m3_s",), ("analytic_load_flow_m3_s",), 6e4),
)


def _simulated(found: Mapping[str, Any]) -> str:
    by_key = {(each["point"], each["design"]): each for each in found["simulated"]}
    lines = []
    for point in sorted({point for point, _ in by_key}):
        where = f" (point {point + 1})" if len(found["points"]) > 1 else ""
        for label, simulated, analytic, scale in COMPARED:
            cells = [text(label + where)]
            for design in ("before", "after"):
                each = by_key.get((point, design), {})
                pair = [
                    scale * sum(each[k] for k in keys) if each.keys() >= set(keys) else float("nan")
                    for keys in (simulated, analytic)
                ]
                cells += [
                    number(pair[0], 4),
                    number(pair[1], 4),
                    percent(pair[1] / pair[0] - 1.0) if pair[0] else "&ndash;",
                ]
            lines.append(row(cells, ("", *("n",) * 6)))
    head = ("", "before, simulated", "analytic", "difference", "optimum, simulated", "analytic", "difference")
    return table(head, lines, range(1, 7))


# Tolerances

TOLERANCE = "tolerance.json"


def write_tolerance_report(directory: Path) -> Path:
    """Writes report.html and figures/ beside the files of a tolerance study and gives the path of the page."""
    found = read_numbers(directory, TOLERANCE)
    figures = tuple(tolerance_figures(found))
    return written(directory, f"{found['title']}: tolerances", _tolerance(found, figures), figures)


def _tolerance(found: Mapping[str, Any], figures: Sequence[Drawn]) -> Iterator[str]:
    yield f'<p class="lead">{_tolerance_in_words(found)}</p>'
    if found["warnings"]:
        told = "".join(f"<p>{text(each[:1].upper() + each[1:])}.</p>" for each in found["warnings"])
        yield f'<div class="notice"><strong>What is in doubt</strong>{told}</div>'
    yield from (figure(each.svg, each.name, count, text(each.caption)) for count, each in enumerate(figures, 1))
    yield "<h2>Outputs</h2>"
    head = ("output", "nominal", "mean", "deviation", "2.5 %", "median", "97.5 %")
    yield table(head, [_scatter(name, each) for name, each in found["scatter"].items()], range(1, 7))
    yield "<h2>Spreads taken</h2>"
    assumed = sum(each["status"] == "assumed" for each in found["spreads"])
    yield f"<p>{assumed} of {len(found['spreads'])} spreads are merely assumed; the shares hang on them.</p>"
    yield table(("input", "from, to", "status", "source", "note"), [_spread(each) for each in found["spreads"]])
    yield (
        f'<p class="small">{found["evaluations"]} analytic designs: the fully open valve for drop and frequency, '
        "the sum of the losses at the operating point of the system for the efficiency. A sum of the shares below 1 is "
        "interaction; a share may come out slightly below zero by chance.</p>"
    )


def _tolerance_in_words(found: Mapping[str, Any]) -> str:
    by_name = {each["name"]: each["words"] for each in found["spreads"]}
    parts = []
    for name, each in found["scatter"].items():
        main = max(each["whole"], key=each["whole"].__getitem__)
        low, high = (quantity(each["percentiles"][p], name) for p in ("2.5", "97.5"))
        parts.append(
            f"the {text(words(name))} lies between {low} and {high} in 95 % of the cases, mostly through the "
            f"{text(by_name[main])} ({percent(each['whole'][main], 0)} of the variance)"
        )
    told = "; ".join(parts)
    return told[:1].upper() + told[1:] + "."


def _scatter(name: str, each: Mapping[str, Any]) -> str:
    p = each["percentiles"]
    values = (each["nominal"], each["mean"], each["deviation"], p["2.5"], p["50"], p["97.5"])
    return row([text(words(name)), *(quantity(value, name) for value in values)], ("", *("n",) * 6))


def _spread(each: Mapping[str, Any]) -> str:
    status = f'<span class="assumed">{each["status"]}</span>' if each["status"] == "assumed" else text(each["status"])
    cells = [text(each["words"]), text(each["shown"]), status, text(each["source"]), text(each["note"])]
    return row(cells, ("", "u", "", "", "q"))


# Oil temperature

TEMPERATURE = "temperature.json"


def write_temperature_report(directory: Path) -> Path:
    """Writes report.html and figures/ beside the files of a study over temperature and gives the path of the page."""
    found = read_numbers(directory, TEMPERATURE)
    figures = tuple(temperature_figures(found))
    return written(directory, f"{found['title']}: oil temperature", _temperature(found, figures), figures)


def _temperature(found: Mapping[str, Any], figures: Sequence[Drawn]) -> Iterator[str]:
    t, c = found["temperatures"], found["columns"]
    ends = f"{t[0] - 273.15:.4g} and {t[-1] - 273.15:.4g} °C"
    frequency, efficiency = c["pwm_frequency"], c["efficiency"]
    yield (
        f'<p class="lead">Between {ends} the PWM frequency of the fully open valve goes from '
        f"{number(frequency[0], 3)} to {number(frequency[-1], 3)} Hz, the efficiency from {percent(efficiency[0])} to "
        f"{percent(efficiency[-1])}, at {fixed(6e4 * found['flow_m3_s'], 1)} lpm, "
        f"{fixed(found['load_pressure_Pa'] / 1e5, 0)} bar load, relief valve at "
        f"{fixed(found['relief_pressure_Pa'] / 1e5, 0)} bar and duty ratio {number(found['duty_ratio'], 3)}.</p>"
    )
    if found["warnings"]:
        told = "".join(f"<p>{text(each[:1].upper() + each[1:])}.</p>" for each in found["warnings"])
        yield f'<div class="notice"><strong>Where the model is in doubt</strong>{told}</div>'
    yield from (figure(each.svg, each.name, count, text(each.caption)) for count, each in enumerate(figures, 1))
    yield '<h2 class="page">Values</h2>'
    head = (
        "oil", "viscosity mPa s", "PWM open Hz", "PWM mean Hz", "drop bar", "total loss W", "leakage W", "efficiency",
        "eccentricity",
    )  # fmt: skip
    yield table(head, list(_temperature_rows(t, c)), range(9))
    yield "<h2>Checks</h2>"
    lines = [
        row(
            [
                text(each["words"]), text(each["low"]), text(each["high"]),
                f"{'at least' if each['at_least'] else 'at most'} {text(each['limit'])}",
                "in doubt" if any(each["outside"]) else "kept",
            ],
            ("", "n", "n", "n", "q"),
        )
        for each in found["checks"]
    ]  # fmt: skip
    yield table(("", "lowest", "highest", "limit", ""), lines, (1, 2, 3))
    yield "<h2>Limits and values taken</h2>"
    lines = [
        row([text(words(each["name"])), number(each["value"], 4), text(each["origin"])], ("", "n", "q"))
        for each in found["limits"]
    ]
    yield table(("", "value", "origin"), lines, (1,))


def _temperature_rows(t: Sequence[float], c: Mapping[str, Sequence[float]]) -> Iterator[str]:
    every = max(1, round(10.0 / (t[1] - t[0])))
    for k in range(0, len(t), every):
        cells = (
            f"{t[k] - 273.15:.4g} °C", number(1e3 * c["viscosity"][k], 3), number(c["pwm_frequency"][k], 3),
            number(c["pwm_frequency_averaged"][k], 3), number(1e-5 * c["pressure_drop_total"][k], 4),
            number(c["loss_total"][k], 4), number(c["loss_leakage"][k], 3), percent(c["efficiency"][k]),
            number(c["eccentricity"][k], 2),
        )  # fmt: skip
        yield row(cells, ("n",) * len(cells))


# Pareto front


def write_front_report(directory: Path) -> Path:
    """Writes report.html and figures/ beside the files of a Pareto front and gives the path of the page."""
    found = read_numbers(directory, NUMBERS_OF_FRONT)
    figures = tuple(front_figures(found))
    return written(directory, f"{found['title']}: Pareto front", _front(found, figures), figures)


def _front(found: Mapping[str, Any], figures: Sequence[Drawn]) -> Iterator[str]:
    good = ", ".join(
        f"{'large' if each['large'] else 'small'} {words(each['quantity'])}" for each in found["objectives"]
    )
    demands = f", subject to {', '.join(found['limits'])}" if found["limits"] else ""
    yield (
        f'<p class="lead">{len(found["designs"])} designs between which only a choice decides: {text(good + demands)}. '
        f"{text(_beaten(found))}</p>"
    )
    if found["warnings"]:
        told = "".join(f"<p>{text(each[:1].upper() + each[1:])}.</p>" for each in found["warnings"])
        yield f'<div class="notice bad"><strong>Look at the simulation before you choose</strong>{told}</div>'
    if not found["finished"]:
        yield '<div class="notice"><strong>The search was interrupted</strong><p>The front is a rough one.</p></div>'
    yield from (figure(each.svg, each.name, count, text(each.caption)) for count, each in enumerate(figures, 1))
    yield '<h2 class="page">Designs</h2>'
    yield (
        '<p class="small">Each is a system file in systems/ that <code>vvdp run</code> simulates. Begun with the '
        f"optimum of each objective alone; evolution looked at {found['evaluations']} designs, and a gradient solver "
        "moved each onto the front.</p>"
    )
    names = [each["quantity"] for each in found["objectives"]]
    variables = [each["name"] for each in found["bounds"]]
    simulated = found["simulated"]
    head = (
        "system",
        *(text(words(name)) for name in names),
        *(("total loss, simulated",) if simulated else ()),
        *(text(each["words"]) for each in found["bounds"]),
    )
    lines = []
    for count, each in enumerate(found["designs"], 1):
        cells = [text(Path(each["file"]).stem)]
        cells += [quantity(each["quantities"][name], name, 3) for name in names]
        if simulated:
            told = quantity(simulated[count]["loss_total"], "loss_total", 3)
            cells.append(f'<span class="assumed">{told}, in doubt</span>' if simulated[count]["doubts"] else told)
        cells += [quantity(each["values"][name], name, 3) for name in variables]
        lines.append(row(cells, ("u", *("n",) * (len(cells) - 1))))
    yield table(head, lines, range(1, len(head)))
    doubtful = [
        f"<li>{text(Path(each['file']).stem)}: {text('; '.join(simulated[count]['doubts']))}</li>"
        for count, each in enumerate(found["designs"], 1)
        if simulated and simulated[count]["doubts"]
    ]
    if doubtful:
        yield f"<h2>Designs in doubt</h2>\n<ul>{''.join(doubtful)}</ul>"
    yield "<h2>Bounds</h2>"
    lines = [
        row(
            [text(each["words"]), quantity(each["low"], each["name"]), quantity(each["high"], each["name"])],
            ("", "n", "n"),
        )
        for each in found["bounds"]
    ]
    yield table(("variable", "from", "to"), lines, (1, 2))


def _beaten(found: Mapping[str, Any]) -> str:
    """How many designs are better than the one as it was in every objective."""
    count = sum(
        all(
            (each["quantities"][o["quantity"]] - found["before"][o["quantity"]]) * (-1.0 if o["large"] else 1.0) <= 0.0
            for o in found["objectives"]
        )
        for each in found["designs"]
    )
    if not count:
        return "None of them is better than the design as it was in every objective."
    return (
        f"{count} of them {'are' if count > 1 else 'is'} at least as good as the design as it was in every objective."
    )
