"""Every value has a kind, every formula a source, every quantity one word, symbol and unit."""

import inspect
import re
from dataclasses import is_dataclass
from enum import Enum

import pytest

from vvdp.base.conservation import Books, Stored
from vvdp.base.params import Params, field_kinds, field_types
from vvdp.base.slots import slot_of

NO_QUANTITY = {"Stepping.method"}  # a choice


def is_nested(hint) -> bool:
    is_record = isinstance(hint, type) and (hasattr(hint, "_fields") or is_dataclass(hint))
    return is_record or slot_of(hint) is not None


def leaf_fields(classes):
    """(class, field, kind) of every field of a parameter class or state that is not itself one."""
    for cls in classes:
        for name, kind in field_kinds(cls).items():
            if not is_nested(field_types(cls)[name]):
                yield cls, name, kind


def is_state(cls) -> bool:
    return hasattr(cls, "_fields") and (cls.__name__.endswith("State") or cls.__name__ == "Spool")


@pytest.fixture(scope="module")
def parameters_and_states(value_classes):
    return [c for c in value_classes if issubclass(c, Params) or is_state(c)]


@pytest.fixture(scope="module")
def entries(value_classes):
    """Classes whose fields are entries of books, but for the names of nodes and components."""
    return [Stored, *(c for c in value_classes if c.__name__.endswith("Losses"))]


def test_every_parameter_and_state_has_a_kind(parameters_and_states):
    missing = [
        f"{cls.__name__}.{name}"
        for cls, name, kind in leaf_fields(parameters_and_states)
        if kind is None and f"{cls.__name__}.{name}" not in NO_QUANTITY
    ]
    assert not missing
    assert len(parameters_and_states) > 20


def test_values_without_a_kind_are_choices():
    from vvdp.simulation.run import Stepping

    assert issubclass(field_types(Stepping)["method"], Enum)


def test_examples_of_kinds_can_be_read(parameters_and_states):
    """The example in every error message is itself valid."""
    from vvdp.base.units import parse

    for _, _, kind in leaf_fields(parameters_and_states):
        if kind:
            parse(kind.example, kind)


def source_of(documented) -> re.Match | None:
    """The Source line of a function, or of the module for all that name no other."""
    return re.search(r"Source\s+(.*)\Z", inspect.getdoc(documented) or "", re.DOTALL)


def test_every_formula_has_a_source(formula_modules, functions_of, root):
    keys = set(re.findall(r"^@\w+\{([^,]+),", (root / "docs/references.bib").read_text("utf-8"), re.MULTILINE))
    keys |= {"ours"}
    faults, count = [], 0
    for module in formula_modules:
        for name, function in functions_of(module).items():
            count += 1
            told = source_of(function) or source_of(module)
            cited = set(re.findall(r"\b(?:[a-z]+\d{4}|astm-d341|i(?:so|ec)\d+|ours)\b", told[1])) if told else set()
            if not cited:
                faults.append(f"{module.__name__}.{name}: no Source line")
            elif not cited <= keys:
                faults.append(f"{module.__name__}.{name}: unknown {sorted(cited - keys)}")
            if told and (page := re.search(r"docs/models/[\w-]+\.md", told[1])) and not (root / page[0]).is_file():
                faults.append(f"{module.__name__}.{name}: no {page[0]}")
    assert not faults, "\n".join(faults)
    assert count > 80


def test_both_lists_of_references_are_the_same(root, source):
    """The package carries its own copy for reports."""
    inside = source / "report/references.bib"
    assert inside.read_text("utf-8") == (root / "docs/references.bib").read_text("utf-8")


@pytest.fixture(scope="module")
def nomenclature(root):
    """(word, symbol, unit) of every row."""
    text = (root / "docs/nomenclature.md").read_text("utf-8")
    rows = re.findall(r"^\| `(\w+)` \| ([^|]*) \| ([^|]*) \| ([^|]*) \|$", text, re.MULTILINE)
    assert [row for row in rows if not all(cell.strip() for cell in row)] == []
    return [row[:3] for row in rows]


def test_nomenclature_has_every_field_with_its_unit(parameters_and_states, entries, nomenclature):
    written = {(word, unit) for word, _, unit in nomenclature}
    needed = {(n, k.unit) for _, n, k in leaf_fields([*parameters_and_states, *entries, Books]) if k}
    assert sorted(needed - written) == []


def test_nomenclature_names_nothing_twice(nomenclature):
    words = [(word, unit) for word, _, unit in nomenclature]
    symbols = [symbol for _, symbol, _ in nomenclature]
    assert len(set(words)) == len(words)
    assert sorted(s for s in set(symbols) if symbols.count(s) > 1) == []


def test_nomenclature_has_nothing_that_does_not_exist(value_classes, nomenclature):
    known = {name for cls in [*value_classes, Books] for name in field_kinds(cls)}
    assert sorted({word for word, _, _ in nomenclature} - known) == []
