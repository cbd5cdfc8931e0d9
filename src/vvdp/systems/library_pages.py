"""Descriptions of the components and programs of the library for users, collected from the code.

Meanings of words are those of docs/nomenclature.md, which the package carries.
"""

import ast
import dataclasses
import inspect
import re
import textwrap
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache
from importlib import resources
from typing import Any, get_origin

from vvdp.base.display import value_text
from vvdp.base.kinds import PRESSURE_DIFFERENCE, PRESSURE_LEVEL, Kind
from vvdp.base.params import Params, default_values, field_kinds, field_names, field_types
from vvdp.base.slots import TableSlot, inner_slots
from vvdp.base.tables import parsed_table
from vvdp.components.library import COMPONENTS
from vvdp.hydraulics.relief_valve import ReliefValve
from vvdp.network.assembly import Assembly
from vvdp.network.component import Component
from vvdp.network.network import JOINS
from vvdp.network.nodes import kind_of_node
from vvdp.network.program import ProgramType
from vvdp.programs.generic import GenericProgram
from vvdp.programs.library import PROGRAMS
from vvdp.programs.quantities import OF_ANY_QUANTITY
from vvdp.systems.library_examples import FOLDER, example_text, example_values, toml_text
from vvdp.systems.part_scopes import as_table
from vvdp.systems.plausibility import LARGEST_TRANSITION

UNLIMITED = 1e300
"""A default value from which on it says that there is no limit."""
FORMULAS = tuple(
    f"vvdp.{name}."
    for name in ("hydraulics", "fluid", "valve", "control", "estimation", "sensing", "components", "programs")
)
"""Packages whose functions are shown as equations if a component or program calls them."""
ROW = re.compile(r"^\| `(\w+)` \| ([^|]*) \| ([^|]*) \| ([^|]*) \|$", re.MULTILINE)
LAST_PARAGRAPHS = re.compile(r"\n\s*\n(?:Source|Holds|Error)  .*\Z", re.DOTALL)


@dataclass(frozen=True)
class Described:
    """A value, input or output: example as a file gives it and usual value as people read it; empty without one."""

    name: str
    meaning: str
    unit: str
    example: str = ""
    usual: str = ""

    @property
    def line(self) -> str:
        """As a file gives it, with the usual value in brackets."""
        given = f"{self.name} = {self.example}" if self.example else self.name
        return f"{given} [{self.usual}]" if self.usual else given


@dataclass(frozen=True)
class Equation:
    """A function that is called while a circuit runs: its first sentence, its text, and where it comes from."""

    name: str
    description: str
    text: str
    source: str


@dataclass(frozen=True)
class LibraryPage:
    """All about one type; `ports` of a component are what a program `reads` otherwise."""

    type: str
    description: str
    ports: tuple[Described, ...]
    inputs: tuple[Described, ...]
    values: tuple[Described, ...]
    outputs: tuple[Described, ...]
    equations: tuple[Equation, ...]
    rules: tuple[str, ...]
    warnings: tuple[str, ...]
    example: str


@cache
def library_page(kind: str) -> LibraryPage:
    """The page of a component or program of the library."""
    if kind in PROGRAMS:
        return _program_page(kind, PROGRAMS[kind])
    found = COMPONENTS[kind]
    return _assembly_page(kind, found) if isinstance(found, Assembly) else _component_page(kind, found)


def _component_page(kind: str, component: Component) -> LibraryPage:
    hydraulic = component.hydraulic_ports
    ports = [
        Described(port, "" if port in hydraulic else f"({kind_of_node(JOINS[role][0])})", "")
        for port, role in component.ports.items()
    ]
    given = example_values(kind)
    inputs = [_value(each.name, each.kind, given, each.default, kind) for each in component.inputs]
    inputs += [
        replace(_value(each.name, each.kind, given, None, kind), usual=f"instead of {name}")
        for name, each in component.alternatives.items()
    ]
    outputs = [_value(name, each, {}, None, kind) for name, each in component.outputs.items()]
    return LibraryPage(
        type=kind,
        description=description_of(component.law),
        ports=tuple(ports),
        inputs=tuple(inputs),
        values=tuple(_values(component.params, given, kind)),
        outputs=tuple(outputs),
        equations=tuple(_equations(component.law)),
        rules=tuple(_rules(component.params)),
        warnings=tuple(_warnings(component.params)),
        example=example_text(kind) or "",
    )


def _assembly_page(kind: str, assembly: Assembly) -> LibraryPage:
    given = example_values(kind)
    values = [*_values([assembly.params], given, kind)]
    if assembly.holds_oil:
        words, unit = "pressure of its oil at first", PRESSURE_LEVEL.display_unit
        values.append(Described("start", words, unit, toml_text(given["start"])))
    return LibraryPage(
        type=kind,
        description=description_of(assembly.add),
        ports=tuple(Described(port, "", "") for port in assembly.ports),
        inputs=tuple(_value(name, each, given, None, kind) for name, each in assembly.inputs.items()),
        values=tuple(values),
        outputs=(),
        equations=tuple(_equations(assembly.add)),
        rules=tuple(_rules([assembly.params])),
        warnings=(),
        example=example_text(kind) or "",
    )


def _program_page(kind: str, program: ProgramType | GenericProgram) -> LibraryPage:
    own = program.type if isinstance(program, GenericProgram) else program
    given, settings = example_values(kind), [own.settings] if own.settings else []
    reads = [
        _value(name, each, given, own.defaults.get(name), kind)
        for name, each in field_kinds(own.reading).items()
        if name != "time"
    ]
    return LibraryPage(
        type=kind,
        description=description_of(own.step),
        ports=(),
        inputs=tuple(reads),
        values=tuple(_values(settings, given, kind)),
        outputs=tuple(_value(name, each, {}, None, kind) for name, each in field_kinds(type(own.command)).items()),
        equations=tuple(_equations(own.step)),
        rules=tuple(_rules(settings)),
        warnings=(),
        example=example_text(kind) or "",
    )


def description_of(function: Callable[..., Any]) -> str:
    """The docstring of a function without where it comes from."""
    return LAST_PARAGRAPHS.sub("", inspect.getdoc(function) or "").strip()


def _values(classes: Sequence[type[Params]], given: Mapping[str, object], of: str) -> Iterator[Described]:
    for cls in classes:
        usual, types, slots = default_values(cls), field_types(cls), inner_slots(cls)
        for name, kind in field_kinds(cls).items():
            if name in slots:
                yield from _inner_values(slots[name], name, as_table(given.get(name)), of)
                continue
            found = _value(name, kind, given, usual.get(name), of)
            is_list = get_origin(types[name]) is tuple and kind is not None and name not in given
            yield dataclasses.replace(found, example=f"[{found.example}, ...]") if is_list else found


def _inner_values(slot: TableSlot, name: str, given: Mapping[str, object], of: str) -> Iterator[Described]:
    """The values of a table inside of the settings of a program, `gains.error_rate`, each once."""
    found = {each.name: each for each in _values(slot.classes, given, of)}
    needed = () if slot.optional else field_names(slot.classes[0])
    for key, each in found.items():
        usual = each.usual or ("" if key in needed else "none")
        yield dataclasses.replace(each, name=f"{name}.{key}", usual=usual)


def value_lines(cls: type[Params]) -> list[str]:
    """The values of a class, each as a file gives it."""
    return [each.line for each in _values([cls], {}, "")]


def _value(name: str, kind: Kind | None, given: Mapping[str, object], usual: Any, of: str) -> Described:
    """A value `of` a type: its example is that of the library's file, else its usual value, else that of its kind."""
    if kind is None:
        return Described(name, "", "", toml_text(given[name]) if name in given else "")
    several = usual if isinstance(usual, tuple) else () if usual is None else (usual,)
    shown = ", ".join(value_text(each, kind) for each in several) or ("none" if usual == () else "")
    is_limit = isinstance(usual, float) and abs(usual) >= UNLIMITED
    is_written = isinstance(usual, float) and not is_limit
    plain = shown.partition(" (")[0] if is_written else kind.example
    return Described(
        name=name,
        meaning=meaning_of(name, kind, of),
        unit="any" if kind in OF_ANY_QUANTITY else kind.display_unit or "1",
        example=toml_text(given.get(name, plain)),
        usual="none" if is_limit else shown,
    )


def meaning_of(name: str, kind: Kind, of: str) -> str:
    """The meaning of a word of a type of the library."""
    special, usual = _words()["types"], _words()["words"]
    own = special.get(of, {})
    own = special.get(own.get("as"), {}) | own
    found: str = own.get(name) or meanings().get((name, kind.unit)) or usual.get(name, "")
    return found


@cache
def _words() -> Mapping[str, Any]:
    """The meanings of inputs and outputs, by name, or by type and name."""
    return parsed_table((FOLDER / "words.toml").read_text("utf-8"), "words.toml").content


@cache
def meanings() -> Mapping[tuple[str, str], str]:
    """Symbol and meaning of each word, by the word and its SI unit."""
    text = (resources.files("vvdp.systems") / "nomenclature.md").read_text("utf-8")
    return {(word, unit.strip()): meaning.strip() for word, _, unit, meaning in ROW.findall(text)}


def _equations(function: Callable[..., Any], depth: int = 2) -> Iterator[Equation]:
    """A function and the formulas that it calls, each once, in the order of the calls."""
    seen: set[Callable[..., Any]] = set()

    def walk(each: Callable[..., Any], left: int) -> Iterator[Equation]:
        if each in seen:
            return
        seen.add(each)
        yield _equation(each)
        for called in _called_functions(each) if left else ():
            yield from walk(called, left - 1)

    return walk(function, depth)


@cache
def _equation(function: Callable[..., Any]) -> Equation:
    doc = inspect.getdoc(function) or ""
    module = inspect.getdoc(inspect.getmodule(function)) or ""
    source = re.search(r"Source  (.*?)(?=\n\w+  |\n\n|\Z)", doc, re.DOTALL)
    source = source or re.search(r"Source  (.*?)(?:, where a function names no other|\n\n|\Z)", module, re.DOTALL)
    words = " ".join(source[1].split()) if source else ""
    return Equation(function.__name__, doc.partition("\n\n")[0].replace("\n", " "), _code(function), words)


def _code(function: Callable[..., Any]) -> str:
    """The text of a function without its docstring."""
    text = textwrap.dedent(inspect.getsource(function))
    tree = ast.parse(text).body[0]
    assert isinstance(tree, ast.FunctionDef)
    first = tree.body[0]
    if not (
        isinstance(first, ast.Expr) and isinstance(first.value, ast.Constant) and isinstance(first.value.value, str)
    ):
        return text
    lines = text.splitlines()
    return "\n".join([*lines[: first.lineno - 1], *lines[first.end_lineno :]])


@cache
def _called_functions(function: Callable[..., Any]) -> tuple[Callable[..., Any], ...]:
    """The formulas of the package that a function calls, and the laws of the components that it adds."""
    tree, calls = ast.parse(textwrap.dedent(inspect.getsource(function))), []
    for name in dict.fromkeys(node.id for node in ast.walk(tree) if isinstance(node, ast.Name)):
        named = inspect.unwrap(function).__globals__.get(name)
        found = named.law if isinstance(named, Component) else named
        if inspect.isfunction(found) and found.__module__.startswith(FORMULAS):
            calls.append(found)
    return tuple(calls)


def _rules(classes: Sequence[type[Params]]) -> Iterator[str]:
    """Rules that values of the classes must keep, read from the calls of `base.rules` in their checks."""
    checks = {
        vars(cls)["check"] for each in classes for cls in each.__mro__ if "check" in vars(cls) and cls is not Params
    }
    for check in sorted(checks, key=lambda each: each.__qualname__):
        for node in ast.walk(ast.parse(textwrap.dedent(inspect.getsource(check)))):
            if isinstance(node, ast.Call) and isinstance(node.func, ast.Name):
                words = [f"`{each.value!s}`" for each in node.args[1:] if isinstance(each, ast.Constant)]
                if node.func.id == "require_positive" and words:
                    yield f"{', '.join(words)}: greater than 0"
                elif node.func.id == "require_less" and len(words) == 2:
                    yield f"{words[0]}: less than {words[1]}"
                elif node.func.id == "require_rising" and words:
                    yield f"{words[0]}: rising from row to row"
                elif node.func.id == "refuse" and len(words) == 2:
                    yield f"{words[0]}: {words[1].strip('`')}"


def _warnings(classes: Sequence[type[Params]]) -> Iterator[str]:
    """Warnings of a run about values of the classes."""
    if any("transition_pressure" in field_kinds(cls) for cls in classes):
        limit = value_text(LARGEST_TRANSITION, PRESSURE_DIFFERENCE)
        yield f"`transition_pressure` above {limit}: the flow would be laminar up to this pressure drop"
    if any(issubclass(cls, ReliefValve) for cls in classes):
        yield "closed for the whole run while the pressure behind it is above its setting: the ports may be exchanged"
