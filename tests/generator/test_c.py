"""C text: clean under every compiler, legible, without memory of its own; faults planted in its writer are found."""

import ctypes
import os
import re
import signal
import subprocess
from functools import cache

import numpy as np
import pytest
from tests.generator import programs
from tests.generator.c_way import CLEAN, Workspace, c_entries, compile_c, compilers
from tests.generator.test_checked import CHECKED, raises, section
from tests.generator.ways import module_of, run

from vvdp.base.powers import power
from vvdp.generator import (
    c_arithmetic,
    c_expressions,
    c_statements,
    c_writer,
    llvm_statements,
    tree,
)
from vvdp.generator.c_joining import join_steps
from vvdp.generator.c_writer import write_c
from vvdp.generator.kinds import FLOAT, INT, Intrinsic, kind_of
from vvdp.generator.library import Failure
from vvdp.generator.python_writer import run_python
from vvdp.generator.unit import Options, Unit
from vvdp.generator.verify import verify

NAMED = [(f"{number}-{function.__name__}", function, cases) for number, (function, cases) in enumerate(programs.CASES)]
needs_compiler = pytest.mark.skipif(not compilers(), reason="no C compiler")


@pytest.mark.sampled(2)
@needs_compiler
@pytest.mark.parametrize("compiler", compilers())
def test_every_construct_compiles_without_a_warning(compiler, tmp_path):
    sources = []
    for name, function, cases in NAMED:
        own = f"m{name.partition('-')[0]}"
        for tier, options in (("", Options()), ("checked", CHECKED)):
            made = write_c(module_of(function, cases[0], options), own + tier)
            (tmp_path / f"{own}{tier}.h").write_text(made.header, "utf-8")
            (tmp_path / f"{own}{tier}.c").write_text(made.source, "utf-8")
            sources.append(f"{own}{tier}.c")
    command = [compiler, *c_writer.FLAGS, *CLEAN, "-O2", "-c", *sources]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr[:3000]


@pytest.mark.parametrize("function", [case[0] for case in programs.CASES], ids=[name for name, *_ in NAMED])
def test_joined_steps_are_a_verified_tree_with_the_bits_of_cpython(function):
    cases = next(cases for one, cases in programs.CASES if one is function)
    module = module_of(function, cases[0])
    joined = verify(join_steps(module))
    assert sum(1 for f in joined.functions for _ in llvm_statements.statements_in(f.body)) <= sum(
        1 for f in module.functions for _ in llvm_statements.statements_in(f.body)
    )
    if function is not programs.library_functions:
        way = run_python(joined)["entry"]
        assert [run(way, values) for values in cases] == [run(function, values) for values in cases]


@cache
def every_program():
    """All programs of the language that end whatever fault there is, and have one result, as one module."""
    unit = Unit()
    for name, function, cases in NAMED:
        if function not in (programs.while_loops, programs.library_functions):
            unit.add(function, [kind_of(value) for value in cases[0]], f"n{name.replace('-', '_')}")
    return verify(unit.module())


def wrong_programs(extra=("-O0",)):
    """The programs whose C gives other bits than CPython."""
    entries = c_entries(every_program(), compilers()[0], extra)
    found = []
    for name, function, cases in NAMED:
        way = entries.get(f"n{name.replace('-', '_')}")
        if way is not None and any(run(way, values) != run(function, values) for values in cases):
            found.append(name)
    return found


@needs_compiler
@pytest.mark.parametrize("extra", [("-O0",), ("-O3", "-march=native"), ("-O2", "-fsanitize=undefined")])
def test_every_level_has_the_bits_of_cpython(extra):
    """Under the sanitiser, what C leaves undefined would end the process."""
    assert wrong_programs((*extra, "-fno-sanitize-recover=all") if "sanitize" in extra[-1] else extra) == []


@needs_compiler
@pytest.mark.parametrize("x", [0.3, 2.0, 7.5])
def test_functions_of_the_library_are_those_of_the_machine_code(x):
    from tests.generator.ways import results

    found = results(programs.library_functions, x)
    assert found["C"] == found["level 2"]


def named(t, valve):
    """Flow through the valve. And more words."""
    return t * valve.area


def test_the_text_is_legible():
    made = write_c(module_of(named, (1.0, programs.stand_in(programs.Valve)(0.5, 0.1))), "flow")
    line = named.__code__.co_firstlineno
    assert f"/* Flow through the valve. test_c.py:{line} */\ndouble flow_entry(double t, const flow_Valve *valve)" in (
        made.source
    )
    assert "typedef struct {\n    double area;\n    double lap;\n} flow_Valve;" in made.header
    assert "    return t * valve->area;\n}" in made.source


@pytest.mark.parametrize("function", [case[0] for case in programs.CASES], ids=[name for name, *_ in NAMED])
def test_there_is_no_heap_and_nothing_outlives_a_call(function):
    cases = next(cases for one, cases in programs.CASES if one is function)
    made = write_c(module_of(function, cases[0]), "m")
    assert not re.search(r"\b(malloc|calloc|realloc|free|goto|alloca)\b", made.source)
    kept = [line for line in made.source.splitlines() if re.match(r"(static )?(double|int64_t|bool)[^()]*[;=]", line)]
    assert kept == []  # tables are constant
    assert not re.search(r"^ +(double|int64_t) \w+\[[^\]]*[a-z]", made.source, re.M)  # no array of unknown length


@needs_compiler
def test_fast_arithmetic_is_refused():
    made = write_c(module_of(programs.sums, (1.0, 2.0)), "m")
    with pytest.raises(AssertionError, match="IEEE 754"):
        compile_c(made, compilers()[0], ("-ffast-math",))


@needs_compiler
def test_the_workspace_is_the_callers_and_its_end_is_a_failure():
    module = module_of(programs.many_arrays, (3,))
    made = write_c(module, "m")
    assert "m_workspace *workspace" in made.header
    assert " * m_entry: 100 reals, 0 wholes at most\n" in made.header
    run_ = compile_c(made, compilers()[0]).m_entry
    run_.restype = ctypes.c_double
    for count, failed in ((99, 1), (100, 0)):
        numbers, failure = np.zeros(count), ctypes.c_int64(7)
        room = Workspace(numbers.ctypes.data, count, None, 0)
        found = run_(ctypes.c_int64(1000), ctypes.byref(failure), ctypes.byref(room))
        assert failure.value == failed
        assert failed or found == 1000 * 999 / 2  # the room of 100 numbers serves all 1000 calls, one after the other


def ramp(count):
    """An array of 30 numbers, or one of 50: each function takes the room of its result from its caller."""
    if count < 5:
        short = np.empty((30,))
        short[:] = count
        return short[:20]
    long = np.empty((50,))
    long[:] = count
    return long[:20]


def either_array(count):
    first = ramp(count)[0]
    if count > 7:
        return first + ramp(count)[1]
    return first


def ramps(count):
    return either_array(count) + either_array(count + 1)


@needs_compiler
def test_of_two_branches_the_larger_counts_and_a_function_gives_back_what_it_took():
    """Each array takes 30 or 50 numbers; `either_array` takes two, and twice one after the other: 2 * 50."""
    made = write_c(module_of(ramps, (3,)), "m")
    assert " * m_entry: 100 reals, 0 wholes at most\n" in made.header
    run_ = compile_c(made, compilers()[0]).m_entry
    run_.restype = ctypes.c_double
    for argument, count, failed in ((9, 99, 1), (9, 100, 0), (1, 29, 1), (1, 30, 0)):
        numbers, failure = np.zeros(count), ctypes.c_int64(7)
        room = Workspace(numbers.ctypes.data, count, None, 0)
        found = run_(ctypes.c_int64(argument), ctypes.byref(failure), ctypes.byref(room))
        assert failure.value == failed
        assert failed or found == {9: 9 + 9 + 10 + 10, 1: 1 + 2}[argument]


def test_room_that_depends_on_the_arguments_is_said_to():
    cases = dict(programs.CASES)
    held = write_c(module_of(programs.held_arrays, cases[programs.held_arrays][0]), "m")
    assert " * m_entry: depends on the arguments\n" in held.header


@needs_compiler
def test_failures_have_their_numbers_and_reasons():
    made = write_c(module_of(raises, (1.0,)), "m")
    assert re.search(r" \* 1: test_checked\.py:\d+: ValueError", made.header)
    way = c_entries(module_of(section, (programs.ROW, 5), CHECKED), compilers()[0])["entry"]
    with pytest.raises(Failure, match="a slice that is not within its array"):
        way(programs.ROW, 9)


def raised(x):
    return power(x, 1.5)


def test_an_intrinsic_without_c_text_is_refused():
    options = Options(intrinsics={power: Intrinsic("own_power", (FLOAT, FLOAT), "", np.float_power)})
    with pytest.raises(ValueError, match="no C text for own_power"):
        write_c(module_of(raised, (2.0,), options), "m")
    made = write_c(
        module_of(raised, (2.0,), options), "m", {"own_power": "static double own_power(...) { pow(x, y); }"}
    )
    assert "own_power(x, 1.5)" in made.source
    assert "-fno-builtin-pow" in made.flags


def swap_branches(original):
    return lambda text, s: original(text, tree.If(s.test, s.otherwise, s.then, s.line))


def lose_value(original):
    return lambda text, s: original(
        text, tree.Set(s.variables[:-1], s.values[:-1], s.line) if len(s.variables) > 1 else s
    )


def one_by_one(original):
    def write(text, s):
        for variable, value in zip(s.variables, s.values, strict=True):
            original(text, tree.Set((variable,), (value,), s.line))

    return write


def swap_operands(original):
    return lambda text, v: original(
        text, type(v)(v.sign, v.right, v.left, *([v.kind] if isinstance(v, tree.Binary) else []))
    )


def first_field(original):
    return lambda text, v: (
        original(text, tree.Field(v.record, 0, v.kind)) if v.record.kind.fields[0] == v.kind else original(text, v)
    )


def no_exhausted(original):
    return lambda text, s: original(text, s if ends(s.exhausted) else tree.For(s.variable, s.range, s.body, (), s.line))


def ends(block):
    return not llvm_statements.falls_through(block)


def one_round_more(original):
    return lambda text, s: original(
        text,
        tree.For(
            s.variable,
            (s.range[0], tree.Binary("+", s.range[1], tree.Constant(INT, 1), INT), s.range[2]),
            s.body,
            s.exhausted,
            s.line,
        ),
    )


EXPRESSIONS, STATEMENTS, HELPERS = c_expressions.WRITTEN, c_statements.WRITTEN, c_arithmetic.HELPERS
FAULTS = [
    ("swapped branches", STATEMENTS, tree.If, swap_branches),
    ("a lost value", STATEMENTS, tree.Set, lose_value),
    ("assignments one by one", STATEMENTS, tree.Set, one_by_one),
    ("continue leaves the loop", STATEMENTS, tree.Continue, lambda original: lambda text, s: text.put("break;")),
    (
        "a store is lost",
        STATEMENTS,
        tree.Store,
        lambda original: lambda text, s: None if len(s.indexes) == 2 else original(text, s),
    ),
    ("the else of a loop is lost", STATEMENTS, tree.For, no_exhausted),
    ("one round too many", STATEMENTS, tree.For, one_round_more),
    (
        "a choice the wrong way round",
        EXPRESSIONS,
        tree.Choose,
        lambda original: lambda text, v: original(text, tree.Choose(v.test, v.otherwise, v.then)),
    ),
    ("operands of a comparison swapped", EXPRESSIONS, tree.Compare, swap_operands),
    ("operands of an operator swapped", EXPRESSIONS, tree.Binary, swap_operands),
    ("the first field for every other", EXPRESSIONS, tree.Field, first_field),
    (
        "a slice from the start",
        EXPRESSIONS,
        tree.View,
        lambda original: lambda text, v: original(text, tree.View(v.array, tree.Constant(INT, 0), v.sizes, v.kind)),
    ),
    ("rows for columns", c_expressions, "item", lambda original: lambda text, a, i: original(text, a, i[::-1])),
    ("no brackets", c_expressions, "strength", lambda original: lambda value: c_expressions.NAME),
    ("< for <=", c_expressions.ORDERS, "<=", lambda original: "<"),
    ("> for >=", c_expressions.ORDERS, ">=", lambda original: ">"),
    ("+ for -", c_expressions.WHOLE, "-", lambda original: "add64"),
    ("a sum for a product", c_expressions.SIGNS, "*", lambda original: ("+", c_expressions.SUM)),
    ("or for and", c_expressions.TRUTH_SIGNS, "&", lambda original: "||"),
    ("bits of one for both", c_expressions.BIT_SIGNS, "&", lambda original: "|"),
    ("// towards zero", HELPERS, "floor_div64", lambda original: original.replace("(rest < 0) != (b < 0)", "false")),
    ("% towards zero", HELPERS, "floor_mod64", lambda original: original.replace("rest + b", "rest")),
    ("the sign is shifted out", HELPERS, "shr64", lambda original: original.replace("a < 0", "false")),
    ("a float rounded, not cut", HELPERS, "cut64", lambda original: original.replace("(int64_t)x", "(int64_t)rint(x)")),
    (
        "a signed zero loses its sign",
        c_expressions,
        "constant",
        lambda original: lambda kind, value: original(kind, abs(value) if kind is FLOAT else value),
    ),
    (
        "room that is handed out twice",
        c_writer,
        "ROOM",
        lambda original: original.replace("workspace->{free} += count;", ""),
    ),
    ("lengths in the wrong order", c_expressions, "length_names", lambda original: lambda n, k: original(n, k)[::-1]),
]


@pytest.mark.sampled(4)
@needs_compiler
@pytest.mark.parametrize(("words", "place", "name", "fault"), FAULTS, ids=[row[0] for row in FAULTS])
def test_a_planted_fault_is_found(monkeypatch, words, place, name, fault):
    if isinstance(place, dict):
        monkeypatch.setitem(place, name, fault(place[name]))
    else:
        monkeypatch.setattr(place, name, fault(getattr(place, name)))
    assert is_found(), words


def is_found():
    """Whether a program gives other bits, is refused by the compiler, crashes or does not end, in a process of its own.

    A fault may write outside of arrays.
    """
    every_program()
    child = os.fork()
    if child == 0:
        signal.alarm(60)
        try:
            os._exit(1 if wrong_programs() else 0)
        except AssertionError:  # the compiler has refused the text
            os._exit(1)
        finally:
            os._exit(2)
    code = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
    assert code != 2, "the fault is none of the text, but an error of the test"
    return code != 0


@needs_compiler
def test_what_finds_faults_finds_none_without_one():
    assert not is_found()


def inner(x):
    """Half of a number."""
    return 0.5 * x


def busy(x):
    """What runs often."""
    return inner(x) + 1.0


def idle(x):
    """What runs seldom."""
    return x - 1.0


def both(x):
    """An entry that calls either."""
    return busy(x) + idle(x)


def test_what_does_not_run_often_is_told():
    """What is called by a function that runs often runs often; entries are never marked."""
    unit = Unit()
    unit.add(both, [FLOAT], "both")
    source = write_c(verify(unit.module()), "m", often=("busy",)).source
    heads = re.findall(r"^(SELDOM |)(?:static )?double (\w+?)(?:_f\d+)?\(", source, re.M)
    assert {name: bool(mark) for mark, name in heads} == {"inner": False, "busy": False, "idle": True, "m_both": False}
    assert "SELDOM" not in write_c(verify(unit.module()), "m").source


def four_of(x):
    """A loop of four rounds, and one of six."""
    total = 0.0
    for i in range(4):
        total += x * i
    for i in range(6):
        total -= x + i
    return total


@pytest.mark.parametrize(("unrolled", "loops"), [(8, 0), (4, 1), (3, 2)])
def test_loops_are_written_out_up_to_the_asked_number_of_rounds(unrolled, loops):
    unit = Unit(Options(unrolled=unrolled))
    unit.add(four_of, [FLOAT], "four_of")
    assert write_c(verify(unit.module()), "m").source.count("for (int64_t") == loops
