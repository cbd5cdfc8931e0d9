"""Every construct of the language, five ways with one result."""

import pytest
from tests.generator import programs
from tests.generator.ways import module_of, results, run, ways_of


@pytest.mark.parametrize(
    ("function", "cases"), programs.CASES, ids=[f"{n}-{f.__name__}" for n, (f, _) in enumerate(programs.CASES)]
)
def test_five_ways_agree_to_the_bit(function, cases):
    ways = ways_of(module_of(function, cases[0]))
    for values in cases:
        expected = run(function, values)
        assert {name: run(way, values) for name, way in ways.items()} == dict.fromkeys(ways, expected), values


@pytest.mark.parametrize("x", [0.3, 2.0, 7.5])
def test_functions_of_the_library_are_the_same_in_all_written_forms(x):
    """CPython's own may differ by one unit in the last place, where NumPy does not call the C library."""
    found = results(programs.library_functions, x)
    del found["CPython"]
    assert set(found.values()) == {found["tree"]}
