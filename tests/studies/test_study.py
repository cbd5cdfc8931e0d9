"""What a study varies: grids, draws, written cases, and the file that says so."""

from pathlib import Path

import numpy as np
import pytest
from tests.words import wording

from vvdp.base.errors import ConfigError, ParameterError
from vvdp.studies.study import Normal, Random, Study, Uniform, load_study

FILE = """
title = "Clearance and duty"
system = "prototype"
until = "0.1 s"
outputs = ["efficiency", "loss_nozzle_W"]

[settings]
"operation.pump_speed" = "1500 rpm"

[grid]
operation.duty_ratio = ["0.3", "0.5"]

[random]
count = 3
seed = 7
[random.spreads]
"valve.radial_clearance" = { normal = "12.7 um", deviation = "0.5 um" }
oil.air_fraction = { uniform = ["0.5 %", "2 %"] }
"""


def written(folder: Path, text: str) -> Path:
    path = folder / "study.toml"
    path.write_text(text)
    return path


def test_a_grid_is_every_combination_in_order() -> None:
    cases = Study("prototype", {"a.x": ["1", "2"], "b.y": ["3", "4", "5"]}, ()).cases
    assert ["".join(case.values()) for case in cases] == ["13", "14", "15", "23", "24", "25"]
    assert all(list(case) == ["a.x", "b.y"] for case in cases)


def test_draws_come_from_the_seed_alone_and_more_leave_the_earlier_ones() -> None:
    spreads = {"a.x": Uniform("1 bar", "2 bar"), "a.y": Normal("12.7 um", "0.5 um")}
    few, more = Random(spreads, 5, 1), Random({**spreads, "a.z": Uniform("0", "1")}, 9, 1)
    for number in range(5):
        assert few.draw(number).items() <= more.draw(number).items()
    assert few.draw(0) != few.draw(1)
    assert few.draw(0) != Random(spreads, 5, 2).draw(0)
    cases = Study("prototype", Random(spreads, 2, 1, {"b.u": ["0.3", "0.5"]}), ()).cases
    assert [case["b.u"] for case in cases] == ["0.3", "0.3", "0.5", "0.5"]
    assert cases[0]["a.x"] == cases[2]["a.x"]  # the same draws at every point of the grid


def test_draws_have_the_distribution_that_was_asked_for() -> None:
    random = Random({"a.x": Uniform("1 bar", "3 bar"), "a.y": Normal("10 um", "2 um")}, 4000, 3)
    draws = [random.draw(number) for number in range(4000)]
    x = np.array([float(draw["a.x"].removesuffix(" bar")) for draw in draws])
    y = np.array([float(draw["a.y"].removesuffix(" um")) for draw in draws])
    # Within five standard errors: 2/sqrt(12)/sqrt(4000) of the mean of x, 2/sqrt(4000) of that of y.
    assert abs(x.mean() - 2.0) < 5 * 0.577 / 63.2 and x.min() >= 1.0 and x.max() <= 3.0
    assert abs(y.mean() - 10.0) < 5 * 2.0 / 63.2
    # A normal cut at three deviations has 0.9866 of its deviation.
    assert abs(y.std() / (0.9866 * 2.0) - 1.0) < 5 / np.sqrt(2 * 4000)
    assert abs(y - 10.0).max() <= 6.0
    assert abs(np.corrcoef(x, y)[0, 1]) < 5 / 63.2


def test_spreads_need_one_unit_and_the_right_order() -> None:
    uniform = (Uniform("1 bar", "2 MPa"), Uniform("2 bar", "1 bar"))
    for spread in (*uniform, Normal("1 bar", "0.1 MPa"), Normal("1 bar", "-1 bar")):
        with pytest.raises(ParameterError, match=wording.study.one_unit):
            spread.quantile(0.5)
    with pytest.raises(ParameterError, match=wording.files.is_no_number_with_unit):
        Uniform("low", "high").quantile(0.5)


def test_a_file_says_all_that_python_can(tmp_path: Path) -> None:
    study = load_study(written(tmp_path, FILE))
    spreads = {"valve.radial_clearance": Normal("12.7 um", "0.5 um"), "oil.air_fraction": Uniform("0.5 %", "2 %")}
    assert study == Study(
        "prototype",
        Random(spreads, 3, 7, {"operation.duty_ratio": ["0.3", "0.5"]}),
        ("efficiency", "loss_nozzle_W"),
        ("operation.pump_speed=1500 rpm",),
        "0.1 s",
        "Clearance and duty",
    )
    assert len(study.cases) == 6


def test_a_file_may_write_cases_out_and_vary_signals(tmp_path: Path) -> None:
    text = """
system = "mine.toml"
outputs = ["efficiency"]
[settings]
"load.area" = { step = ["1 mm^2", "2 mm^2"], at = "1 s" }
[[cases]]
"operation.duty_ratio" = "0.3"
[[cases]]
operation.duty_ratio = { step = ["0.4", "0.6"], at = "0.1 s" }
"""
    (tmp_path / "mine.toml").write_text("")
    study = load_study(written(tmp_path, text))
    assert study.system == str(tmp_path / "mine.toml")
    area = {"load.area": {"step": ["1 mm^2", "2 mm^2"], "at": "1 s"}}
    assert study.cases == [
        {**area, "operation.duty_ratio": "0.3"},
        {**area, "operation.duty_ratio": {"step": ["0.4", "0.6"], "at": "0.1 s"}},
    ]


def test_all_faults_of_a_file_are_told_at_once_with_their_lines(tmp_path: Path) -> None:
    text = """system = 3
output = ["efficiency"]
until = 0.5
[grid]
"duty_ratio" = ["0.3"]
"oil.air_fraction" = "1 %"
[random]
count = 0
seed = 1.5
[random.spreads]
"oil.density" = { normal = "876 kg/m^3" }
"valve.radial_clearance" = { uniform = ["1 um", "2 mm"] }
[[cases]]
"pump.displacement" = "20 cc/rev"
"""
    with pytest.raises(ConfigError) as caught:
        load_study(written(tmp_path, text))
    assert [(fault.line, fault.key) for fault in caught.value.faults] == [
        (2, "output"),
        (1, "system"),
        (3, "until"),
        (0, "outputs"),
        (5, "grid.duty_ratio"),
        (6, "grid.oil.air_fraction"),
        (8, "random.count"),
        (9, "random.seed"),
        (11, "random.spreads.oil.density"),
        (12, "random.spreads.valve.radial_clearance"),
        (13, "cases"),
    ]
    with pytest.raises(ConfigError, match=wording.study.nothing_varied):
        load_study(written(tmp_path, 'system = "prototype"\noutputs = ["efficiency"]\n'))


def test_a_length_without_unit_is_told_with_its_line(tmp_path: Path) -> None:
    text = 'system = "prototype"\nuntil = "0.5"\noutputs = ["efficiency"]\n[grid]\n"load.pressure" = "1 bar"\n'
    with pytest.raises(ConfigError) as caught:
        load_study(written(tmp_path, text))
    assert [(fault.line, fault.key) for fault in caught.value.faults] == [(2, "until"), (5, "grid.load.pressure")]
