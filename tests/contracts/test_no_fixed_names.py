"""Above the machines nothing reaches into parameters, states, balances or outputs by a fixed name.

What a verb needs of a rotary valve it asks the bench for. The names that are forbidden are the shipped systems' own.
"""

import ast
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import NamedTuple

import pytest
from tests.contracts.conftest import tree_of

from vvdp.simulation.values import leaves, names
from vvdp.systems.system import load_system, shipped_systems

PACKAGES = (
    "runs",
    "api",
    "studies",
    "steady",
    "rigs",
    "design",
    "cfd",
    "comparison",
    "export",
    "fitting",
    "geometry",
    "logs",
    "offline",
    "report",
    "web",
    "workbench",
    "cli",
)
BY_NAME = {"reproduction"}
"""Works out published cases, each of its own system, and names its parts as a person's script does."""
OWN = {"evaluation", "machines", "rivals"}
"""Speak for the benches, and draw circuits of their own."""
HOLDERS = frozenset(
    ("state", "states", "params", "outputs", "books", "totals", "spent", "supplied", "tables")
    + ("command", "commands", "held", "memory", "settings")
    + ("final_state", "final_command", "final_memory", "final_case")
)
"""What holds the values of a case or a run; behind one of these no name of a circuit may stand."""
ALLOWED: dict[tuple[str, str], str] = {}
"""Places, by file and what was found there, with the reason why it cannot be said in another way."""


class Names(NamedTuple):
    """What a circuit calls its own: single names, and whole paths that nothing else is called."""

    words: frozenset[str]
    paths: frozenset[str]


@cache
def forbidden() -> Names:
    """The names of all shipped systems."""
    words, paths, keys = {"supply"}, set[str](), set[str]()
    for name in shipped_systems():
        system = load_system(name)
        case = system.case
        outputs = system.model.circuit(0.0, case.state, case.command, case.params)[1]
        inside = {path for value in (case.state, outputs) for path, _, _ in leaves(value)}
        paths |= inside
        keys |= {row.key for row in system.rows}
        words |= {*names(case.params), *names(case.command), *case.memory, *system.tables}
        words |= {word for path in inside for word in path.split(".")}
    # One word may mean anything, and what a person writes in a file is everybody's.
    found = {path for path in paths - keys if "." in path or path.count("_") > 1}
    inner = {path.removeprefix("books.") for path in found if path.startswith("books.")}
    return Names(frozenset(words), frozenset(found | {path for path in inner if "." in path}))


def chain(node: ast.expr) -> tuple[str, ...]:
    """The names of `a.b["c"].d` from left to right; what is called or computed on the way is '()'."""
    match node:
        case ast.Attribute(value=inner, attr=name):
            return (*chain(inner), name)
        case ast.Subscript(value=inner, slice=ast.Constant(value=str(name))):
            return (*chain(inner), name)
        case ast.Call(func=ast.Attribute(value=inner, attr="get"), args=[ast.Constant(value=str(name)), *_]):
            return (*chain(inner), name)
        case ast.Call(func=ast.Name(id="getattr"), args=[inner, ast.Constant(value=str(name)), *_]):
            return (*chain(inner), name)
        case ast.Name(id=name):
            return (name,)
    return ("()",)


def reaches(tree: ast.AST) -> Iterator[tuple[int, str]]:
    """Line and text of each place where a name of a circuit is used."""
    known, holding = forbidden(), set(aliases(tree))
    for node in ast.walk(tree):
        if isinstance(node, ast.Attribute | ast.Subscript | ast.Call):
            parts = chain(node)
            holds = parts[-2:-1] and (parts[-2] in HOLDERS if len(parts) > 2 else parts[0] in holding)
            held = holds and parts[-1] in known.words
            whole = any(".".join(parts[first:]) in known.paths for first in range(len(parts) - 1))
            if held or whole or parts[-1] == "supply":
                yield node.lineno, ".".join(parts)
            if isinstance(node, ast.Call):
                yield from replaced(node, known)
        elif isinstance(node, ast.Constant) and isinstance(node.value, str) and node.value in known.paths:
            yield node.lineno, repr(node.value)


def aliases(tree: ast.AST) -> Iterator[str]:
    """Names under which a file knows what holds values: `state` after `state = run.state`."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Assign):
            for target in node.targets:
                both = isinstance(target, ast.Tuple) and isinstance(node.value, ast.Tuple)
                pairs = zip(target.elts, node.value.elts, strict=False) if both else [(target, node.value)]
                for name, value in pairs:
                    parts = chain(value)
                    if isinstance(name, ast.Name) and len(parts) > 1 and parts[-1] in HOLDERS:
                        yield name.id


def replaced(call: ast.Call, known: Names) -> Iterator[tuple[int, str]]:
    """Names of a circuit with which parts of a case are replaced: `replace(case.params, load=...)`."""
    match call:
        case ast.Call(func=ast.Attribute(value=held, attr="_replace")):
            pass
        case ast.Call(func=ast.Name(id="replace"), args=[held]):
            pass
        case _:
            return
    if len(chain(held)) > 1 and chain(held)[-1] in HOLDERS:
        yield from ((call.lineno, f"{keyword.arg}=") for keyword in call.keywords if keyword.arg in known.words)


@pytest.mark.parametrize("package", PACKAGES)
def test_no_circuit_is_reached_into_by_a_fixed_name(source: Path, package: str) -> None:
    found = [
        f"{path.relative_to(source)}:{line}: {text}"
        for path in sorted((source / package).glob("**/*.py"))
        for line, text in reaches(tree_of(path))
        if (str(path.relative_to(source)), text) not in ALLOWED
    ]
    assert not found, "ask the system instead, as `vvdp.evaluation.bench.rotary_bench` lets you:\n" + "\n".join(found)


def test_all_packages_above_systems_are_looked_at(source: Path) -> None:
    above = {path.parent.name for path in source.glob("*/__init__.py")}
    below = {"base", "fluid", "numerics", "results", "valve", "hydraulics", "sensing", "estimation", "control"}
    below |= {"generator"}
    assert above - below - {"simulation", "network", "components", "programs", "systems"} - OWN - BY_NAME == set(
        PACKAGES
    )


def test_names_are_those_of_the_shipped_systems() -> None:
    known = forbidden()
    assert {"inlet", "load_line", "relief_valve", "valve_load_flow", "spool", "motor"} <= known.words
    assert {"spool.speed", "books.totals.inlet_pressure", "totals.inlet_pressure", "valve_load_flow"} <= known.paths


@pytest.mark.parametrize(
    "line",
    [
        "flow = system.case.params.pump.displacement",
        "here = case.params.supply",
        "speed = run.state.spool.speed",
        "spool = run.final_state.spool",
        "p = first.spool.speed",
        "state, t = run.state, 0.0\nlevel = state.inlet",
        "tables = system.tables\nrated = tables['motor'].rated_power",
        "mean = found.books.totals.inlet_pressure",
        "level = run.outputs.valve_load_flow",
        "level = getattr(run.outputs, 'valve_load_flow')",
        "rated = system.tables['motor'].rated_power",
        "limits = system.tables.get('limits')",
        "told = results.states['spool.speed']",
        "path = 'books.totals.load_line_pressure'",
        "flow = output('valve_load_flow')",
        "angle = run.command.encoder.angle",
        "values = run.case.settings['encoder']",
        "other = replace(case.params, load=wider)",
        "other = case.state._replace(inlet=1e5)",
    ],
)
def test_a_planted_line_is_found(line: str) -> None:
    assert list(reaches(ast.parse(line)))


@pytest.mark.parametrize(
    "line",
    [
        "flow = bench.pump.displacement",
        "paths = [path for path, _, _ in leaves(case.state)]",
        "case = replace(case, state=as_value(case.state, shifted))",
        "mean = bench.mean(run.outcome, bench.LOAD_TOTAL)",
        "threads = get_worker().state.nthreads",
        "column = results.states[path]",
        "edge = memory.encoder",
        "from vvdp.evaluation.bench import rotary_bench",
    ],
)
def test_what_is_asked_for_is_not_found(line: str) -> None:
    assert not list(reaches(ast.parse(line)))
