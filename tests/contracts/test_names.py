"""Functions are named as actions (`predict`, `write_report`) or as what they return (`orifice_flow`), never by a bare
participle, which says neither; and what others may call is described."""

import ast
from collections.abc import Iterator

import pytest
from tests.contracts.conftest import tree_of

WORDS = """
asked become been begun bent bitten borne bought bred broken brought built caught chosen clung dealt done
drawn dreamt driven dug dwelt eaten fallen fed felt fled flown forbidden forgotten fought found frozen given
gone got grown had heard held hidden hung kept known laid led left lent lit lost made meant met mistaken
overcome paid proven rebuilt redone redrawn resent rewritten ridden risen said sat seen sent sewn shaken shone
shot shown shrunk sold sought sped spent spoken spun stolen stood struck stuck sung sunk swept sworn swum
swung taken taught thought thrown told torn understood undone unknown unseen untold upheld withheld woken won
worn woven written
"""
IRREGULAR = frozenset(WORDS.split())
NO_PARTICIPLES = {
    "bleed",
    "breed",
    "embed",
    "exceed",
    "feed",
    "heed",
    "indeed",
    "need",
    "proceed",
    "seed",
    "speed",
    "succeed",
}
ALLOWED: dict[str, str] = {}
"""Functions that may bear a bare participle, by module and name, with the reason."""
DESCRIBED_BY_CLASS = {"check"}
"""Methods that every class of a kind has, described where the kind is."""


def is_participle(word: str) -> bool:
    """Whether a word alone is a past participle, as far as its form says."""
    word = word.strip("_")
    return word not in NO_PARTICIPLES and (
        word in IRREGULAR or ("_" not in word and word.endswith("ed") and len(word) > 3)
    )


def functions(node: ast.AST, where: str) -> Iterator[tuple[str, ast.FunctionDef]]:
    """Every function and method below a node, with its dotted name."""
    for child in ast.iter_child_nodes(node):
        named = isinstance(child, ast.FunctionDef | ast.ClassDef)
        inside = f"{where}.{child.name}" if isinstance(child, ast.FunctionDef | ast.ClassDef) else where
        if isinstance(child, ast.FunctionDef):
            yield inside, child
        yield from functions(child, inside if named else where)


def bare_participles(tree: ast.AST, where: str) -> list[str]:
    return [name for name, each in functions(tree, where) if is_participle(each.name)]


@pytest.fixture(scope="module")
def trees(source) -> dict[str, ast.Module]:
    """The text of every module, by its dotted name below vvdp."""
    return {
        ".".join(path.relative_to(source).with_suffix("").parts): tree_of(path) for path in sorted(source.rglob("*.py"))
    }


def test_no_function_is_named_by_a_bare_participle(trees):
    found = {name for module, tree in trees.items() for name in bare_participles(tree, module)}
    assert sorted(found - set(ALLOWED)) == []
    assert sorted(set(ALLOWED) - found) == []


@pytest.mark.parametrize("name", ["written", "_held", "changed", "undominated", "kept"])
def test_a_bare_participle_is_seen(name):
    assert bare_participles(ast.parse(f"class A:\n  def b(self):\n    def {name}(): pass"), "m") == [f"m.A.b.{name}"]


@pytest.mark.parametrize("name", ["write", "held_state", "speed", "feed", "is_written", "run", "orifice_flow", "red"])
def test_verbs_and_nouns_pass(name):
    assert bare_participles(ast.parse(f"def {name}(): pass"), "m") == []


def is_public(name: str) -> bool:
    return not any(part.startswith("_") for part in name.split("."))


def undescribed(tree: ast.Module) -> list[str]:
    """Public functions and methods without a docstring; inner ones and mere forms need none."""
    inner = {id(n) for f in ast.walk(tree) if isinstance(f, ast.FunctionDef) for n in ast.walk(f) if n is not f}
    return [
        name.lstrip(".")
        for name, each in functions(tree, "")
        if is_public(name.lstrip("."))
        and id(each) not in inner
        and each.name not in DESCRIBED_BY_CLASS
        and ast.unparse(each.body[0]) != "..."
        and not ast.get_docstring(each)
    ]


def test_every_public_function_is_described(trees):
    assert [
        f"{module}.{name}" for module, tree in trees.items() if is_public(module) for name in undescribed(tree)
    ] == []


def test_a_missing_description_is_seen():
    text = "def a(): pass\ndef b():\n  'B.'\n  def c(): pass\nclass D:\n  def check(self): pass\n  def e(self): pass\n"
    assert undescribed(ast.parse(text)) == ["a", "D.e"]
