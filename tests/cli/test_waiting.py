"""Long commands say beforehand how long they take, and how much is left; a stopped comparison says what is missing."""

import time
from types import SimpleNamespace

from vvdp.cli.compare import MOST_MISSING, Trials, _few
from vvdp.cli.progress import count_lines
from vvdp.comparison.circuit_trials import CircuitComparison


def test_the_first_line_has_the_usual_time_and_the_next_the_pace(capsys, monkeypatch):
    """65 runs of 5 s each; then 13 of 65 after 26 s: 2 s each, so 104 s for the other 52."""
    clock = iter([100.0, 126.0, 200.0])
    monkeypatch.setattr(time, "monotonic", lambda: next(clock))
    with count_lines("runs", 5.0) as progress:
        progress(0, 65)
        progress(13, 65)
        progress(65, 65)
    said = capsys.readouterr().err.splitlines()
    assert said == ["0 of 65 runs, about 5.42 min", "13 of 65 runs, about 104 s left", "65 of 65 runs"]


def test_an_unknown_time_is_not_invented(capsys):
    with count_lines("points") as progress:
        progress(0, 4)
    assert capsys.readouterr().err == "0 of 4 points\n"


def test_cores_share_the_work():
    assert Trials(cores=2).seconds(5.0) == 2.5
    assert Trials(on="slurm").seconds(5.0) == 0.0


def test_missing_pairs_are_named():
    done = [SimpleNamespace(duty="heavy", circuit="throttle")]
    found = CircuitComparison(
        duties={"heavy": None, "digging": None}, circuits={"vvdp": None, "throttle": None}, found=tuple(done),
        error=None, untuned=(), seconds=1.0, finished=False,
    )  # fmt: skip
    assert found.missing == ("vvdp on heavy", "vvdp on digging", "throttle on digging")
    assert _few([str(n) for n in range(MOST_MISSING + 2)]) == "0, 1, 2, 3, 4 and 2 more"
    assert _few(found.missing) == ", ".join(found.missing)
