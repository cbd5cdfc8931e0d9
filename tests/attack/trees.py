"""What chance and malice make of a text in TOML or JSON, read as a tree, and the tree as TOML again."""

import copy
import json
from collections.abc import Callable, Iterator
from datetime import date
from typing import Any

import numpy as np

Tree = dict[str, Any]
Place = tuple[Any, Any]
"""A table or list of a tree, and the key of an entry in it."""

WORDS = (
    "", " ", "nan bar", "-inf", "1e400 bar", "1e-320 m", "-1 mm", "0", "9" * 4000, "10 bananas", "10 BAR", "10", "5 m",
    "3 kg", "１０ bar", "−5 bar", "5\u200b bar", "\u202ebar 5", "2**3 bar", "9**9**9**9 bar", "sqrt(4) bar",
    "5 bar/bar*bar", "1_0 mm", "0x10 mm", "1e3 1e3", "٣ bar", "__import__('os').system('true') bar", "os:system",
    "/tmp/elsewhere/payload:network", "../../etc/passwd", "payload:network", "<script>alert(1)</script>", "\x1b[2J",
    "%s%n{0.__class__}", "A" * 100_000, "true", "self", "from",
)  # fmt: skip
NAMES = (
    "self", "state", "__class__", "lambda", "x;import os", "é", "ｐｕｍｐ", "a" * 5000, "", " ", "a.b", "..", "/tmp/x",
    "None", "\x1b[2J", "<b>", "run_", "titles", "type", "value", "0", "t",
    "__import__('os')", "x\ny", "Σ", "con", "e" * 300,
)  # fmt: skip
VALUES = (
    None, True, 0, -1, 1.5, 2**63, 10**30, 1e308, float("nan"), float("inf"), [], {}, [[]], ["1 bar"] * 3,
    {"value": {}}, {"from": "pump.speed"}, {"step": {}}, {"table": []}, {"table": [["0 s", "1 bar"], ["0 s", "2 bar"]]},
    date(2000, 2, 29), ["x"] * 20_000, {"sine": {"amplitude": "1 bar", "frequency": "1e99 Hz"}},
    {"value": "1 bar", "range": ["9 bar", "1 bar"]},
)  # fmt: skip
UNITS = ("bar", "mm", "lpm", "rpm", "m", "Pa", "m^3/s", "s", "ms", "degC", "%", "cc", "N", "kW", "1", "inch", "psi")


def changed(tree: Tree, random: np.random.Generator) -> Tree:
    """The tree after one to three accidents, each to an entry somewhere in it."""
    found = copy.deepcopy(tree)
    for _ in range(int(random.choice((1, 1, 1, 2, 3)))):
        ACCIDENTS[int(random.integers(len(ACCIDENTS)))](found, random)
    return found


def _places(part: Any) -> Iterator[Place]:
    for key, value in part.items() if isinstance(part, dict) else enumerate(part):
        yield part, key
        if isinstance(value, dict | list):
            yield from _places(value)


def _any_place(tree: Tree, random: np.random.Generator) -> Place:
    """An entry; those at the top come as often as all others."""
    found = [(tree, key) for key in tree] if random.random() < 0.3 else list(_places(tree))
    return found[int(random.integers(len(found)))] if found else ({"": 0}, "")


def _choice(words: tuple[Any, ...], random: np.random.Generator) -> Any:
    return copy.deepcopy(words[int(random.integers(len(words)))])


def _typo(tree: Tree, random: np.random.Generator) -> None:
    """A key with a letter more, less, changed or of another alphabet."""
    part, key = _any_place(tree, random)
    if isinstance(key, str) and key:
        at = int(random.integers(len(key)))
        letter = _choice(("", key[at] * 2, "x", "_", key[at].upper(), "а", key[at] + "s"), random)
        _rename(part, key, key[:at] + letter + key[at + 1 :])


def _rename(part: Any, key: str, name: str) -> None:
    if name not in part:
        entries = [(name if each == key else each, value) for each, value in part.items()]
        part.clear()
        part.update(entries)


def _hostile_name(tree: Tree, random: np.random.Generator) -> None:
    part, key = _any_place(tree, random)
    if isinstance(key, str):
        _rename(part, key, _choice(NAMES, random))


def _remove(tree: Tree, random: np.random.Generator) -> None:
    part, key = _any_place(tree, random)
    del part[key]


def _copy(tree: Tree, random: np.random.Generator) -> None:
    """An entry stands a second time, under another name or in another table."""
    (part, key), (other, _) = _any_place(tree, random), _any_place(tree, random)
    value = copy.deepcopy(part[key])
    if isinstance(other, list):
        other.append(value)
    else:
        other[f"{key}{_choice(('', '2', '_copy'), random)}"] = value


def _swap(tree: Tree, random: np.random.Generator) -> None:
    (part, key), (other, place) = _any_place(tree, random), _any_place(tree, random)
    part[key], other[place] = copy.deepcopy(other[place]), copy.deepcopy(part[key])


def _word(tree: Tree, random: np.random.Generator) -> None:
    part, key = _any_place(tree, random)
    part[key] = _choice(WORDS, random)


def _value(tree: Tree, random: np.random.Generator) -> None:
    part, key = _any_place(tree, random)
    part[key] = _choice(VALUES, random)


def _number(tree: Tree, random: np.random.Generator) -> None:
    """Another number with the same unit, or another unit with the same number."""
    places = [(part, key) for part, key in _places(tree) if isinstance(part[key], str) and part[key][:1].isdigit()]
    if places:
        part, key = places[int(random.integers(len(places)))]
        number, _, unit = part[key].partition(" ")
        if random.random() < 0.5:
            part[key] = f"{number} {_choice(UNITS, random)}"
        else:
            part[key] = f"{random.normal(1.0, 10.0 ** random.integers(-2, 6)):.6g} {unit}".strip()


def _nest(tree: Tree, random: np.random.Generator) -> None:
    """An entry within tables or lists, in each other up to ninety times."""
    part, key = _any_place(tree, random)
    for _ in range(_choice((1, 2, 90), random)):
        part[key] = _choice(({"value": part[key]}, {"a": part[key]}, [part[key]]), random)


ACCIDENTS: tuple[Callable[[Tree, np.random.Generator], None], ...] = (
    _typo, _typo, _hostile_name, _remove, _copy, _swap, _word, _value, _number, _number, _nest,
)  # fmt: skip


def toml(tree: Tree) -> str:
    """The tree as TOML, a line for each value of a table."""
    return "\n".join(_lines(tree, ())) + "\n"


def _lines(part: Tree, path: tuple[str, ...]) -> Iterator[str]:
    tables = {key: value for key, value in part.items() if isinstance(value, dict) and value and len(path) < 4}
    if path and (len(tables) < len(part) or not part):
        yield f"[{'.'.join(map(_quoted, path))}]"
    for key, value in part.items():
        if key not in tables and value is not None:  # TOML has no word for nothing
            yield f"{_quoted(key)} = {_inline(value)}"
    for key, value in tables.items():
        yield from _lines(value, (*path, key))


def _inline(value: Any) -> str:
    if isinstance(value, dict):
        held = (f"{_quoted(key)} = {_inline(each)}" for key, each in value.items() if each is not None)
        return f"{{ {', '.join(held)} }}"
    if isinstance(value, list):
        return f"[{', '.join(_inline(each) for each in value if each is not None)}]"
    if isinstance(value, str):
        return _quoted(value)
    if isinstance(value, bool):
        return str(value).lower()
    return str(value)


def _quoted(text: str) -> str:
    return json.dumps(text).replace("\x7f", "\\u007f")
