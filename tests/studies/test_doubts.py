"""What is to be known before the numbers of a case reaches whoever runs a study."""

from tests.words import wording

from vvdp.studies.results import study_result
from vvdp.studies.run import run_study
from vvdp.studies.study import Study


def test_cases_outside_the_range_of_a_law_are_named(tmp_path):
    duty = {"operation.duty_ratio": ["0.5", "1.4", "-0.4"]}
    study = Study("prototype-constant-load", duty, ("efficiency", "trusted"), until="0.3 s")
    found = run_study(study, tmp_path / "kept")
    doubts = {doubt.text: doubt.cases for doubt in found.doubts}
    words = "duty ratio: 1.4, outside −0.3501 to 1.35; the spool stands beyond the helix (operation.duty_ratio)"
    assert doubts[words] == (1, 2)
    assert found.outputs["trusted"].values.tolist() == [1.0, 0.0, 0.0]
    said = [finding.text for finding in study_result(found).findings]
    assert wording.study.in_cases.format(cases="1, 2", words=words) in said


def test_a_study_without_doubts_says_nothing(tmp_path):
    study = Study("prototype-constant-load", {"operation.duty_ratio": ["0.5", "0.6"]}, ("efficiency",), until="0.4 s")
    found = run_study(study, tmp_path / "kept")
    assert found.doubts == () and study_result(found).findings == ()
