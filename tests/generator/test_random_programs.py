"""Random programs give the bits of CPython in every way; a failing one is cut down to what matters."""

import pytest
from tests.generator.random_programs import failures, minimised, random_program

from vvdp.generator import llvm_expressions

AT_ONCE = 50


def failing(seeds):
    """The programs among these seeds that fail, cut down."""
    texts = {f"p{seed}": random_program(seed) for seed in seeds}
    found = failures(texts)
    return {name: minimised(texts[name], fails) for name in found}


def fails(text):
    """Whether a program is one of the language and gives other bits somewhere."""
    try:
        return bool(failures({"p": text}))
    except Exception:  # a reduction may have left out what a name needs
        return False


@pytest.mark.sampled(4)
@pytest.mark.parametrize("first", range(0, 500, AT_ONCE))
def test_programs_agree(first):
    assert failing(range(first, first + AT_ONCE)) == {}


@pytest.mark.slow
@pytest.mark.parametrize("first", range(500, 10_000, AT_ONCE))
def test_many_programs_agree(first):
    assert failing(range(first, first + AT_ONCE)) == {}


@pytest.mark.thorough
def test_a_failing_program_is_cut_down_to_ten_lines(monkeypatch):
    monkeypatch.setitem(llvm_expressions.ORDERS, "<", "le")
    found = next(iter(failing(range(20)).values()))
    assert len(found.splitlines()) <= 10, found
    monkeypatch.undo()
    assert not fails(found)


def test_programs_are_the_same_for_the_same_seed():
    assert random_program(7) == random_program(7) != random_program(8)
