"""Runs that go on from others, systems from text, and circuits that are checked and linked once."""

import numpy as np
import pytest

import vvdp
from vvdp.base.errors import ConfigError, RunError
from vvdp.simulation import check, link
from vvdp.systems.system import source_text


@pytest.fixture(scope="module")
def system():
    return vvdp.load("prototype")


@pytest.fixture(scope="module")
def first(system):
    return system.run("0.1 s")


def test_two_parts_equal_the_whole(system, first):
    """Both parts end on a sample, and the second knows its time, commands and memories: the same bits."""
    whole, second = system.run("0.2 s"), first.carried_on(system, until="0.2 s")
    assert np.array_equal(second.done.final, whole.done.final)
    assert second.done.end == whole.done.end == 0.2
    for key in ("pressure_mean_load_line_Pa", "efficiency", "averaged_from_s", "averaged_periods"):
        assert second.summary[key] == whole.summary[key]


def test_balances_begin_at_zero_with_other_values(system, first):
    other = first.carried_on(system.with_values(operation={"duty_ratio": 0.3}), until=0.3)
    assert abs(other.summary["energy_residual"]) < 1e-6
    assert other.summary["averaged_from_s"] >= 0.1
    assert np.array_equal(other.done.initial, first.done.final)


def test_a_slow_way_there_and_back_ends_at_the_same_numbers(system, first):
    run, until = first, 0.1
    for duty in (0.45, 0.4, 0.45, 0.5, 0.5, 0.5):
        until += 0.15
        run = run.carried_on(system.with_values(operation={"duty_ratio": duty}), until=until)
    run, whole = run.carried_on(system, until=until + 1.5), system.run("2 s")
    assert run.summary["pressure_mean_load_line_Pa"] == pytest.approx(
        whole.summary["pressure_mean_load_line_Pa"], rel=5e-3
    )


def test_what_cannot_be_carried_on(system, first, tmp_path):
    with pytest.raises(RunError, match=r"must be greater than 0\.1 s"):
        first.carried_on(system, until="0.05 s")
    with pytest.raises(RunError, match="another model"):
        first.carried_on(vvdp.load("buck-converter"), until="0.2 s")
    saved = vvdp.open(first.save(tmp_path / "run", report=False))
    with pytest.raises(RunError, match="read from a directory"):
        saved.carried_on(system, until="0.2 s")


def test_other_values_are_neither_checked_nor_linked_again(system, first, monkeypatch):
    def refuse(*_):
        raise AssertionError("was done already")

    monkeypatch.setattr(check, "_circuit_is_sound", refuse)
    monkeypatch.setattr(link, "ModelAssemblies", refuse)
    other = system.with_values(operation={"duty_ratio": 0.4})
    assert other.model.circuit is system.model.circuit
    other.run("10 ms")
    vvdp.loads(source_text("prototype")).run("10 ms")


def test_a_text_is_a_system():
    text = source_text("buck-converter")
    assert vvdp.loads(text).title == vvdp.load("buck-converter").title
    lines = text.splitlines()
    with pytest.raises(ConfigError) as found:
        vvdp.loads("\n".join([*lines, "[nonsense]", "key = 1"]))
    assert found.value.faults[0].line in (len(lines) + 1, len(lines) + 2)
