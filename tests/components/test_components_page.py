"""docs/components.md: its tables are those of the library, its code runs."""

import re
from pathlib import Path

from vvdp.base.display import value_text
from vvdp.base.params import default_values, field_kinds
from vvdp.components.library import COMPONENTS
from vvdp.generator.source import known_text
from vvdp.network.assembly import Assembly
from vvdp.network.component import Component, Role
from vvdp.simulation.values import names
from vvdp.systems.drawing import NODES

DOCS = Path(__file__).parents[2] / "docs"
PAGE = (DOCS / "components.md").read_text("utf-8")
ENDS = {Role.SHAFT: " (shaft)", Role.SHAFT_SPEED: " (shaft)", Role.ROD: " (rod)"}


def values(cls):
    """Each value with an example, and with the one that holds where none is given."""
    usual = default_values(cls)
    for name, kind in field_kinds(cls).items():
        given = f" ({value_text(usual[name], kind)})" if isinstance(usual.get(name), float) else ""
        yield f"`{name}` {kind.example}{given}"


def state(cls):
    """The names of a state, at any depth."""
    if cls is None:
        return ()
    kinds = field_kinds(cls)
    return tuple(name for name in names(cls) if kinds[name]) or names(cls)


def told(function):
    """What a function does: the first sentence of its description."""
    first = re.split(r"[.;:]( |\n|$)", function.__doc__, maxsplit=1)[0].replace("\n    ", " ").strip()
    return first.replace("Add a ", "A ")


def sections():
    """Of each type that a page derives, a link to the section with its formulas and their sources."""
    for page in (*(DOCS / "models").glob("*.md"), DOCS / "when-switching-pays.md", DOCS / "small-circuits.md"):
        found = re.findall(r"^## (.+)\n\n\*Types:\* (.+)\.$", page.read_text("utf-8"), re.MULTILINE)
        for title, types in found:
            anchor = re.sub(r"[^a-z0-9 -]", "", title.lower()).replace(" ", "-")
            for name in re.findall(r"`([\w-]+)`", types):
                yield name, f"[{title}]({page.relative_to(DOCS).as_posix()}#{anchor})"


SECTIONS = dict(sections())


def row(name, component):
    doc = told(component.add if isinstance(component, Assembly) else component.law)
    if isinstance(component, Assembly):
        inputs = [f"`{name}` {kind.example}" for name, kind in component.inputs.items()]
        own = [*values(component.params), *(["`start` 100 bar"] if component.holds_oil else [])]
        cells = [component.ports, inputs, own, ("in its pieces",), ()]
    else:
        ports = [f"{port}{ENDS.get(role, '')}" for port, role in component.ports.items()]
        inputs = [
            f"`{a.name}` {a.kind.example}" + ("" if a.default is None else f" ({value_text(a.default, a.kind)})")
            for a in component.inputs
        ]
        inputs += [f"`{a.name}` {a.kind.example} instead of `{name}`" for name, a in component.alternatives.items()]
        own = [line for cls in component.params for line in values(cls)]
        cells = [ports, inputs, own, state(component.state), component.outputs]
    return (
        f"| `{name}` | {doc} | "
        + " | ".join(", ".join(cell) for cell in cells)
        + f" | {component.symbol} | {SECTIONS[name]} |"
    )


def tables():
    """The lines of the tables that the library determines: nodes and components."""
    nodes = [f"| `{name}` | {', '.join(values(node.table))} |" for name, node in NODES.items()]
    parts = [row(name, component) for name, component in COMPONENTS.items()]
    return [[re.sub(r" +", " ", line) for line in table] for table in (nodes, parts)]


def test_the_tables_are_those_of_the_library():
    found = [table.splitlines() for table in re.findall(r"^\|---.*\n((?:\|.*\n)+)", PAGE, re.MULTILINE)]
    assert found[1:3] == tables()


def test_every_derivation_is_of_a_component():
    assert sorted({*SECTIONS} ^ {*COMPONENTS}) == []


def test_every_word_of_a_component_is_described():
    for word in Component.__dataclass_fields__:
        assert f"`{word}`" in PAGE, word


def test_the_code_of_the_page_runs(capsys):
    left = {}
    for code, shown in re.findall(r"```python\n(.*?)```\n(?:\n```text\n(.*?)```\n)?", PAGE, re.DOTALL):
        capsys.readouterr()
        exec(compile(code, known_text(code, "components.md"), "exec"), left)
        assert capsys.readouterr().out == shown
