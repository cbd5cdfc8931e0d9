"""What the language does not have is refused with file, line, construct and what to write instead."""

import linecache

import pytest
from tests.generator import refusals
from tests.generator.programs import Point

from vvdp.generator.kinds import FLOAT, INT, Record, Row
from vvdp.generator.source import LanguageError
from vvdp.generator.unit import Unit

KINDS = {
    "x": FLOAT,
    "n": INT,
    "row": Row(FLOAT, (None,)),
    "grid": Row(FLOAT, (None, None)),
    "p": Record(Point, (FLOAT, FLOAT)),
}
GOLDEN = [
    ("tries", 1, "`try`", "check values with `if` before they are used"),
    ("opens", 1, "`with`", "write plain statements"),
    ("nests", 1, "a function within a function", "define it at the top level of a module"),
    ("recursive", 1, "a call of `recursive` within itself", "write a loop"),
    ("anonymous", 1, "a lambda", "define a function with `def` at the top level"),
    ("dictionary", 1, "a dictionary", "use a NamedTuple"),
    ("unlisted", 1, "a call of `norm`", "use the listed functions (`vvdp list --language`)"),
    ("formatted", 1, "`.hex` of a float", "use functions of numbers"),
    ("mutable", 1, "an assignment to an attribute", "make a new value, with `_replace`"),
    ("element_of_tuple", 1, "a change of a record", "make a new value, with `_replace`"),
    (
        "undefined",
        3,
        "`y` is not assigned on every way to this line",
        "assign it before the branch or loop, with one type",
    ),
    ("unknown", 1, "the name `missing`, which is not assigned here", "assign it on every way to this line"),
    (
        "changing_type",
        4,
        "`value` has values of several types here",
        "assign it before the branch or loop, with one type",
    ),
    ("two_results", 3, "returns of different types", "return values of one type everywhere"),
    ("unknown_index", 1, "an index of a tuple that is not known", "use an array, or a tuple of numbers only"),
    ("behind_the_end", 1, "index 2 of a tuple of 2", "stay within the tuple"),
    ("float_index", 1, "a float as an index", "use a whole number"),
    ("array_truth", 1, "the truth of an array", "compare numbers"),
    ("strided", 1, "a slice with a step", "write a loop"),
    ("ranks", 1, "arrays of different ranks", "write a loop"),
    ("unpacked", 1, "3 values for 2 names", "name each of them"),
    ("more_arguments", 1, "a call of `undefined` with other arguments", "it takes x"),
    ("fewer_arguments", 1, "a call of `undefined` without x", "hand it over"),
    ("star", 0, "`*` or `**` among the arguments of `star`", "name each argument"),
    ("operand", 1, "`and` or `or` of an int", "write `a if test else b`"),
    ("float_bits", 1, "`&` of floats", "use whole numbers or truths"),
    (
        "array_method",
        1,
        "`.cumsum` of an array",
        "use one of copy, fill, item, max, min, ravel, reshape, sum, or a loop",
    ),
    ("field", 1, "`.z` of a Point", "it has x, y"),
    (
        "table",
        1,
        "an array of float64 numbers; expected float64 or int64 in C order",
        "make it with np.array(..., float) or np.int64",
    ),
    ("endless", 1, "an array whose length is not known", "write a loop over `range(x.size)`"),
    ("global_change", 1, "`global`", "hand the value over as an argument and return it"),
    ("comparison", 1, "`is` of numbers", "compare with `==`"),
    ("large", 1, "the whole number 1180591620717411303424", "use numbers of 64 bits"),
    ("changed_table", 1, "a change of an array that is no argument", "copy it with `.copy()` first"),
    ("matches", 1, "`match`", "write `if` and `elif`"),
    ("asynchronous", 1, "`yield`", "return a value"),
    ("walrus", 1, "`:=`", "assign on a line of its own"),
    ("returned_array", 1, "an array that an entry returns", "write its numbers to an array that is handed over"),
]
"""Function, line behind its first, construct, advice."""


def refusal_of(function):
    code = function.__code__
    names = code.co_varnames[: code.co_argcount]
    with pytest.raises(LanguageError) as caught:
        Unit().add(function, [KINDS[name] for name in names], "entry")
    return caught.value


@pytest.mark.parametrize(("name", "line", "construct", "advice"), GOLDEN, ids=[row[0] for row in GOLDEN])
def test_refusal(name, line, construct, advice):
    function = getattr(refusals, name)
    error = refusal_of(function)
    first = function.__code__.co_firstlineno
    assert (error.line - first, error.construct, error.advice) == (line, construct, advice)
    assert error.file == refusals.__file__
    assert str(error) == f"{error.file}:{error.line}: {construct} (in {name}); {advice}"


def test_every_refusal_has_its_golden_message():
    written = {name for name, each in vars(refusals).items() if hasattr(each, "__code__")}
    assert written == {row[0] for row in GOLDEN}


def test_the_innermost_place_is_named():
    assert refusal_of(calls_another).function == "unlisted"


def calls_another(x):
    return refusals.unlisted(x)


def test_a_function_without_text_or_with_a_closure_is_refused():
    found = {}
    exec("def hidden(x): return x", found)
    with pytest.raises(LanguageError, match="no source text for hidden"):
        Unit().add(found["hidden"], [FLOAT], "entry")
    outer = 1.0

    def closes(x):
        return x + outer

    with pytest.raises(LanguageError, match="closes over outer; hand the values over as arguments"):
        Unit().add(closes, [FLOAT], "entry")


def test_text_made_at_run_time_is_read_where_linecache_knows_it():
    text = "def made(x):\n    return x + 1.0\n"
    linecache.cache["<made>"] = (len(text), None, text.splitlines(keepends=True), "<made>")
    found = {}
    exec(compile(text, "<made>", "exec"), found)
    assert Unit().add(found["made"], [FLOAT], "entry").line == 1


def test_functions_made_at_run_time_may_call_each_other():
    text = "def inner(x):\n    return x + 1.0\n\n\ndef outer(x):\n    return inner(x)\n"
    linecache.cache["<pair>"] = (len(text), None, text.splitlines(keepends=True), "<pair>")
    found = {}
    exec(compile(text, "<pair>", "exec"), found)
    assert found["inner"].__module__ is None or found["inner"].__module__ == "builtins"
    assert len(unit_with(found["outer"]).functions) == 2


def unit_with(function):
    unit = Unit()
    unit.add(function, [FLOAT], "entry")
    return unit
