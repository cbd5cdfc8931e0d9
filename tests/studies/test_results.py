"""What a study comes to as a result: table, ranges, charts over what is varied."""

from pathlib import Path

import numpy as np
import pytest
from tests.words import wording

from vvdp.base.kinds import DUTY_RATIO, EFFICIENCY, PRESSURE_LEVEL
from vvdp.report.plot import draw_chart
from vvdp.results.chart import Field, Lines
from vvdp.results.result import Column
from vvdp.studies.results import Failure, StudyResults, study_result
from vvdp.studies.study import Study
from vvdp.systems.system import load_system

DUTIES, PRESSURES = (0.2, 0.4, 0.6), (1e7, 2e7, 3e7)


def results(inputs, efficiency, **more):
    names = {name: sorted(set(column.values.tolist())) for name, column in inputs.items()}
    settings = {"failures": (), "missing": (), "ran": 0, "seconds": 0.0} | more
    return StudyResults(
        study=Study("prototype", names, ("efficiency",)),
        system=load_system("prototype"),
        directory=Path(),
        inputs=inputs,
        outputs={"efficiency": Column(np.array(efficiency, float), EFFICIENCY, "efficiency")},
        **settings,
    )


def duty(values):
    return {"operation.duty_ratio": Column(np.array(values, float), DUTY_RATIO, "operation.duty_ratio")}


def pressure(values):
    return {"load.pressure": Column(np.array(values, float), PRESSURE_LEVEL, "load.pressure")}


def test_one_varied_value_gives_a_line_in_its_order():
    found = study_result(results(duty([0.6, 0.2, 0.4]), [3.0, 1.0, 2.0]))
    (panel,) = found.charts["over-efficiency"].panels
    assert isinstance(panel, Lines) and panel.lines[0].rows == (1, 2, 0)
    assert found.listings["ranges"].rows[1].values == (1.0, 3.0, 2.0)


def test_two_give_a_field_over_their_grid():
    grid = [(d, p) for d in DUTIES for p in PRESSURES]
    inputs = duty([d for d, _ in grid]) | pressure([p for _, p in grid])
    found = study_result(results(inputs, [d * p for d, p in grid]))
    chart = found.charts["over-efficiency"]
    assert isinstance(chart.panels[0], Field)
    assert (chart.panels[0].x, chart.panels[0].y) == ("operation.duty_ratio", "load.pressure_Pa")
    assert found.tables["study"].axes == ("operation.duty_ratio", "load.pressure_Pa")
    assert "<svg" in draw_chart(chart, found.tables).svg
    scattered = study_result(results(duty([0.2, 0.4, 0.6]) | pressure([1e7, 2e7, 1e7]), [1.0, 2.0, 3.0]))
    assert scattered.charts == {}  # no grid
    assert study_result(results(inputs, [1.0] * 9)).charts == {}  # a field of one value has no contours


def test_a_failed_case_and_one_to_come_are_told():
    failure = Failure(1, {}, "cannot go on")
    found = study_result(results(duty([0.2, 0.4, 0.6]), [1.0, np.nan, np.nan], failures=(failure,), missing=(2,)))
    assert not found.finished
    assert found.tables["study"]["failure"].tolist() == ["", "cannot go on", wording.study.not_run_yet]
    assert {key: n.value for key, n in found.numbers.items()} == {"cases": 3, "failed_cases": 1, "missing_cases": 1}
    assert found.flat["efficiency"][0] == 1.0 and found.flat["warnings"] == [
        wording.study.case_failed.format(case=1, reason="cannot go on")
    ]


@pytest.mark.parametrize("count", [11, 13])
def test_of_many_failures_the_first_ten_are_told(count):
    failures = tuple(Failure(k, {}, "no") for k in range(count))
    found = study_result(results(duty(np.linspace(0.1, 0.9, count)), [np.nan] * count, failures=failures))
    assert len(found.findings) == 11 and found.findings[-1].text.startswith(
        wording.study.more_cases.format(count=count - 10)
    )
    assert found.listings["ranges"].rows[1].values == (None, None, None)
