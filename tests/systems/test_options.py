"""What options change in a system file: the length of a run, and what they stand in for is still checked."""

import pytest
from tests.words import wording

from vvdp.base.errors import ConfigError
from vvdp.evaluation.bench import rotary_bench
from vvdp.studies.run import _base
from vvdp.studies.study import Study
from vvdp.systems.system import load_system, source_text


@pytest.fixture
def write(tmp_path):
    """Writes the prototype's file with one text replaced, and returns its path."""

    def written(old: str, new: str) -> str:
        text = source_text("prototype")
        assert old in text
        path = tmp_path / "mine.toml"
        path.write_text(text.replace(old, new), "utf-8")
        return str(path)

    return written


def test_the_share_of_the_file_is_kept_where_nobody_says_from_when():
    system = load_system("prototype-constant-load", until="0.6 s")
    assert (system.stepping.until, system.average_from) == (0.6, 0.3)


def test_an_explicit_start_of_averaging_wins_over_the_length():
    """By share it would be 0.15 s of 0.5 s, and 0.18 s of 0.6 s."""
    system = load_system("prototype-constant-load", ["run.average_from=0.15 s"], until="0.6 s")
    assert (system.stepping.until, system.average_from) == (0.6, 0.15)


def test_a_start_of_averaging_behind_the_end_is_refused():
    with pytest.raises(ConfigError, match=wording.systems.average_from.format(begin="0.7 s", until="0.6 s")):
        load_system("prototype-constant-load", ["run.average_from=0.7 s"], until="0.6 s")


def test_the_same_holds_in_a_study():
    duty = {"operation.duty_ratio": ["0.5"]}
    study = Study("prototype-constant-load", duty, ("efficiency",), ("run.average_from=0.15 s",), "0.6 s")
    assert _base(study).average_from == 0.15


def test_a_bad_length_in_the_file_is_seen_behind_the_option(write):
    path = write('until = "1 s"', 'until = "1 parsec"')
    with pytest.raises(
        ConfigError, match=r"mine.toml:\d+: run.until: '1 parsec' " + wording.files.is_not_a.format(quantity="a time")
    ):
        load_system(path, until="0.2 s")


def test_a_bad_value_in_the_file_is_seen_behind_a_setting(write):
    path = write('liquid_bulk_modulus = { value = "1.4 GPa"', 'liquid_bulk_modulus = { value = "fish"')
    with pytest.raises(ConfigError, match=r"mine.toml:\d+: oil.liquid_bulk_modulus: 'fish'"):
        load_system(path, ["oil.liquid_bulk_modulus=1.5 GPa"])


def test_what_the_file_leaves_to_the_options_is_no_fault(write):
    path = write('duty_ratio = { value = "0.5"', '# duty_ratio = { value = "0.5"')
    assert rotary_bench(load_system(path, ["operation.duty_ratio=0.4"]), "test").duty_ratio.base == 0.4


def test_a_fault_of_a_setting_is_placed_at_the_option():
    outside = wording.files.outside_range.format(value="'-4.5'", low=-1, high=2)
    with pytest.raises(ConfigError, match="^--set: operation.duty_ratio: " + outside):
        load_system("prototype", ["operation.duty_ratio=-4.5"])
    with pytest.raises(
        ConfigError, match="^--set: operation.duty_ratio: between -8.5 and 9.5, .*" + wording.files.is_outside
    ):
        load_system("prototype", ['operation.duty_ratio={sine="0.5", amplitude="9", frequency="5 Hz"}'])


def test_a_bad_length_in_a_setting_is_seen_behind_the_option():
    with pytest.raises(ConfigError, match="run.until: '-5 s' " + wording.files.is_outside):
        load_system("prototype-constant-load", ["run.until=-5 s"], until="2 s")


def test_a_length_set_before_the_averaging_leaves_means_over_the_second_half():
    """By the share of the file's 0.5 s in the 0.4 s that are set, they would begin at 2.5 s of 2 s."""
    system = load_system("prototype-constant-load", ["run.until=0.4 s"], until="2 s")
    assert (system.stepping.until, system.average_from) == (2.0, 1.0)
