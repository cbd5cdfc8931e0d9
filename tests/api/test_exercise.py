"""The exercises of the course: a right answer is right, and each mistake is told in its own words."""

import math
import re
import runpy
from pathlib import Path

import pytest

from vvdp.api.exercise import ALWAYS, Exercise, Mistake
from vvdp.base.display import display_unit

FOLDER = Path(__file__).parents[2] / "docs" / "exercises"
FILES = sorted(FOLDER.glob("*.py"))
BY_HAND = {
    "01_pump_flow": "24 lpm",
    "02_pump_leakage": "18 lpm",
    "03_orifice_pressure": f"{0.5 * 870 * (20 / 60000 / (0.61 * 12e-6)) ** 2 / 1e5} bar",
    "04_cylinder_speed": "100 mm/s",
    "05_cylinder_pressure": "50 bar",
    "06_motor_speed": "1200 rpm",
    "07_relief_loss": f"{155 * 20 / 600} kW",
    "08_compression": "140 bar",
    "09_accumulator": f"{11.01325 / 0.6**1.4 - 1.01325} bar",
    "10_pwm_frequency": f"{3 * 1477 / 60} Hz",
}


@pytest.fixture(scope="module", params=FILES, ids=lambda path: path.stem)
def exercise(request) -> tuple[str, Exercise]:
    return request.param.stem, runpy.run_path(str(request.param))["EXERCISE"]


def written(value: float, exercise: Exercise) -> str:
    """A number [SI] as a student would write it."""
    unit = display_unit(exercise.right.kind)
    return f"{unit.from_si(value):.6g} {exercise.right.kind.display_unit}"


def test_there_are_ten():
    assert [path.stem for path in FILES] == list(BY_HAND)


def test_what_follows_by_hand_is_right(exercise):
    name, found = exercise
    verdict = found.verdict(BY_HAND[name])
    assert verdict.is_right, verdict.words
    assert verdict.words.startswith("Right. The simulation gives ")
    assert found.run.summary["trusted"]


def test_each_mistake_has_its_own_words(exercise):
    _, found = exercise
    right = found.right.value
    for wrong, words in found.mistakes:
        verdict = found.verdict(written(wrong(right), found))
        assert not verdict.is_right
        assert verdict.words == words


def test_usual_mistakes_are_told_apart_from_the_right_number(exercise):
    _, found = exercise
    for wrong, _ in ALWAYS:
        assert not found.verdict(written(wrong(found.right.value), found)).is_right


def test_what_is_no_answer_is_refused_in_words(exercise):
    _, found = exercise
    for text in ("", "many", "12 furlong", "nan", "1e999", "<b>1</b>", "1"):
        verdict = found.verdict(text)
        assert not verdict.is_right and verdict.words
    assert "furlong" in found.verdict("12 furlong").words
    away = found.verdict(written(17.3 * math.pi * found.right.value, found))
    assert not away.is_right and away.words.endswith(found.hint) and "too large" in away.words


def test_a_file_asks_and_answers(capsys):
    found = runpy.run_path(str(FOLDER / "01_pump_flow.py"))["EXERCISE"]
    assert found.main([]) == 0
    asked = capsys.readouterr().out
    assert "16 cm³/rev" in asked and "'40 lpm'" in asked
    assert found.main(["24", "lpm"]) == 0
    assert found.main(["24000 lpm"]) == 1
    assert "powers of ten" in capsys.readouterr().out


def test_the_page_shows_every_exercise_and_what_they_say():
    page = FOLDER.with_suffix(".md").read_text("utf-8")
    assert re.findall(r"^\| `(\w+)\.py` \|", page, re.MULTILINE) == list(BY_HAND)
    shown = re.findall(r'\$ python docs/exercises/(\w+)\.py "(.+)"\n    (.+)\n', page)
    assert len(shown) == 2
    for name, answer, words in shown:
        assert runpy.run_path(str(FOLDER / f"{name}.py"))["EXERCISE"].verdict(answer).words == words


def test_a_file_writes_its_circuit_as_a_page(tmp_path, capsys):
    found = runpy.run_path(str(FOLDER / "07_relief_loss.py"))["EXERCISE"]
    page = tmp_path / "page.html"
    assert found.main(["--page", str(page)]) == 0
    assert 'type="range"' in page.read_text("utf-8")
    assert found.main(["--page", str(page)]) == found.main(["--page"]) == 2
    assert "not there yet" in capsys.readouterr().err


def test_mistakes_of_the_exercise_come_first():
    mistake: Mistake = (lambda right: 2.0 * right, "own words")
    found = Exercise(
        "?", (FOLDER / "01_pump_flow.py").read_text("utf-8").split('"""')[3], "flow_mean_pump_m3_s", "hint", (mistake,)
    )
    assert found.verdict("48 lpm").words == "own words"
