"""What an optimisation leaves: a new system file, and all its numbers for reports and programs."""

import json
import time
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

import vvdp
from vvdp.base.errors import unusable
from vvdp.design.optimise import Moved, Optimum, geometry_of
from vvdp.design.problem import Problem
from vvdp.design.proof import Proof, optimum_system, simulated_means, simulation_doubts
from vvdp.design.quantities import KINDS, Quantities, key
from vvdp.design.variables import VARIABLES, value_in
from vvdp.systems.resolved import resolved_text

SYSTEM = "optimum.toml"
NUMBERS = "design.json"


def flat_results(found: Optimum) -> dict[str, Any]:
    """The optimum as flat numbers: variables and quantities, means over the points, SI units in the keys."""
    problem = found.problem
    values = {key(name, VARIABLES[name].kind): value for name, value in found.values.items()}
    return values | _means(problem, found.after)


def _means(problem: Problem, quantities: Sequence[Quantities]) -> dict[str, float]:
    return {key(name, kind): float(problem.mean(quantities, name)) for name, kind in KINDS.items()}


def content(found: Optimum, proofs: Sequence[Proof], doubts: Sequence[str], moved: Sequence[Moved]) -> dict[str, Any]:
    """All of an optimisation as JSON can hold it."""
    problem = found.problem
    at = problem.points[0].setup
    valve = {row.key: row.source for row in problem.system.rows if row.table == "valve"}
    return {
        "system": problem.system.name,
        "title": problem.system.title,
        "sources": sorted({source for source in valve.values() if source}),
        "objective": problem.objective,
        "limits": [
            {
                "text": str(each),
                "quantity": each.quantity,
                "at_least": each.at_least,
                "exactly": each.exactly,
                "value": each.value,
                "usual": each.usual,
            }
            for each in problem.limits
        ],
        "demands": [each.words for each in geometry_of(problem)],
        "variables": [
            {
                "name": b.variable.name,
                "words": b.variable.words,
                "before": value_in(at, b.variable.name),
                "after": found.values[b.variable.name],
                "low": b.low,
                "high": b.high,
                "low_given": b.low_given,
                "high_given": b.high_given,
            }
            for b in problem.bounds
        ],
        "points": [
            {
                "weight": point.weight,
                "flow_m3_s": point.setup.flow,
                "temperature_K": point.setup.temperature,
                "duty_ratio": point.setup.duty_ratio,
                "load_pressure_Pa": point.setup.load_pressure,
                "relief_pressure_Pa": point.setup.relief_pressure,
                "tank_pressure_Pa": point.setup.tank_pressure,
            }
            for point in problem.points
        ],
        "objective_before": float(problem.mean(found.before, problem.objective)),
        "objective_after": found.objective,
        "before": [q._asdict() for q in found.before],
        "after": [q._asdict() for q in found.after],
        "mean_before": _means(problem, found.before),
        "mean_after": _means(problem, found.after),
        "active": [
            {"text": h.text, "kind": h.kind, "elasticity": h.elasticity, "sensitivity": h.sensitivity}
            for h in found.holding
        ],
        "moved": [asdict(each) for each in moved],
        "search": {
            "starts": found.starts,
            "converged": found.converged,
            "agreeing": found.agreeing,
            "worse_optima": list(found.worse_optima),
            "global_objective": found.global_objective,
            "global_evaluations": found.global_evaluations,
        },
        "finished": found.finished,
        "simulated": [{"design": p.design, "point": p.point, "failure": p.failure, **p.found} for p in proofs],
        "simulated_means": simulated_means(problem, proofs),
        "simulation_doubts": simulation_doubts(found, proofs),
        "doubts": list(doubts),
    }


def write_design(
    folder: Path, found: Optimum, proofs: Sequence[Proof], doubts: Sequence[str], moved: Sequence[Moved]
) -> None:
    """Writes the optimum as a system file, the numbers, and where they come from."""
    problem = found.problem
    asked = [
        f"The optimum of {problem.system.name}: least {problem.objective}",
        *(f"  subject to {limit}{' (usual limit)' if limit.usual else ''}" for limit in problem.limits),
        *(f"  within {b.side(False)} and {b.side(True).split(' ', 1)[1]}" for b in problem.bounds),
    ]
    text = "".join(f"# {line}\n" for line in asked)
    (folder / SYSTEM).write_text(text + "\n" + resolved_text(optimum_system(problem, found.values)), "utf-8")
    write_numbers(folder, NUMBERS, content(found, proofs, doubts, moved))


def write_numbers(folder: Path, name: str, numbers: Mapping[str, Any]) -> None:
    """Writes the numbers of a design study, and beside them when and by what they were made."""
    _write(folder / name, numbers)
    _write(folder / "meta.json", {"vvdp": vvdp.__version__, "written": time.strftime("%Y-%m-%dT%H:%M:%S%z")})


def write_columns(path: Path, columns: Mapping[str, Any]) -> None:
    """Writes columns of numbers as CSV, SI units in the header."""
    lines = [",".join(columns), *(",".join(f"{x:.10g}" for x in line) for line in zip(*columns.values(), strict=True))]
    path.write_text("\n".join(lines) + "\n", "utf-8")


def _write(path: Path, numbers: Mapping[str, Any]) -> None:
    path.write_text(json.dumps(_finite(numbers), indent=1, allow_nan=False) + "\n", "utf-8")


def _finite(value: Any) -> Any:
    if isinstance(value, float):
        return value if abs(value) < float("inf") else None
    if isinstance(value, Mapping):
        return {name: _finite(each) for name, each in value.items()}
    if isinstance(value, list | tuple):
        return [_finite(each) for each in value]
    return value


def read_numbers(directory: Path, name: str = NUMBERS) -> Any:
    """What was written of a design study. Raises ConfigError where `directory` holds none."""
    try:
        return json.loads((directory / name).read_text("utf-8"))
    except FileNotFoundError:
        raise unusable(directory, f"holds no {name}") from None
    except ValueError as problem:
        raise unusable(directory / name, f"is damaged: {problem}") from None
