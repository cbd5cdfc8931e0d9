"""A wheel that is not what `vvdp estimate` is told is found out, or the first warning says what the speed rests on."""

import re

import pytest
from tests.campaign.mistakes import MISTAKES, found

SAID = {"wave sampled too slowly": "samples|alias"}
"""What the first warning must speak of where the speed is wrong; else of the edges in a turn."""

seeds = pytest.mark.parametrize("seed", [0, *(pytest.param(each, marks=pytest.mark.slow) for each in range(1, 8))])


@pytest.mark.sampled(4)
@seeds
@pytest.mark.parametrize("name", MISTAKES)
def test_no_speed_is_wrong_by_a_factor_unless_the_first_warning_says_so(name, seed):
    came = found(MISTAKES[name], seed)
    said = SAID.get(name, "number of sectors|sectors were|edges a turn|edges per turn")
    assert not came.wrong or re.search(said, came.warnings[0] if came.warnings else ""), (came.mean / came.true, came)


@seeds
@pytest.mark.parametrize(
    ("name", "said"),
    [("inverted", "inverted"), ("backward", "backwards"), ("half the sectors", "16"), ("twice the sectors", " 4 ")],
)
def test_what_the_index_shows_is_found_and_said(name, said, seed):
    came = found(MISTAKES[name], seed)
    assert not came.wrong and any(said in each for each in came.warnings), came.warnings


def test_a_wheel_as_it_was_told_raises_nothing():
    came = found(MISTAKES["nothing"], 0)
    assert not came.wrong and came.warnings == ()
