"""The time report of continuous integration: shares of the limit, and what it says of stages and tests."""

import importlib.util
import sys
from pathlib import Path

import pytest

CI = Path(__file__).parents[2] / ".ci" / "stages.py"


@pytest.fixture(scope="module")
def stages():
    found = importlib.util.spec_from_file_location("stages", CI)
    module = importlib.util.module_from_spec(found)
    found.loader.exec_module(module)
    return module


def makefile(folder, **recipes):
    """A Makefile in `folder` with one shell line per target."""
    text = "".join(f"{target}:\n\t@{recipe}\n" for target, recipe in recipes.items())
    (folder / "Makefile").write_text(text)


@pytest.fixture
def run(stages, tmp_path, monkeypatch, capfd):
    """Runs stages of a Makefile made for the test; returns exit code and output."""

    def call(shares, **recipes):
        makefile(tmp_path, **recipes)
        monkeypatch.chdir(tmp_path)
        monkeypatch.setattr(stages, "STAGES", tuple(stages.Stage(*each) for each in shares.items()))
        code = stages.main()
        return code, capfd.readouterr().out

    return call


def test_all_stages_at_twice_their_share_end_within_the_limit(stages):
    assert sum(stage.most for stage in stages.STAGES) < stages.LIMIT == 5400.0
    targets = (CI.parents[1] / "Makefile").read_text("utf-8")
    assert all(f"\n{stage.target}:" in targets for stage in stages.STAGES)


def test_stages_run_in_order_up_to_the_first_that_fails(run):
    code, out = run({"one": 0.1, "two": 0.1, "three": 0.1}, one="echo first", two="exit 3", three="echo third")
    assert code == 2  # of make
    assert "first" in out and "third" not in out
    assert [line.split()[0] for line in out.splitlines() if line.endswith(" s")] == ["one", "two"]


def test_a_stage_beyond_twice_its_share_fails_although_it_passed(run, stages):
    assert run({"quick": 0.1}, quick="true")[0] == 0
    code, out = run({"quick": 0.1, "slow": 1e-5}, quick="true", slow="sleep 0.2")
    assert code == 1
    assert "make slow: 0 s are more than twice its share of the limit, 0 s" in out


def test_the_slowest_tests_are_named_with_their_seconds(run, tmp_path):
    (tmp_path / "test_naps.py").write_text(
        "import time, pytest\n@pytest.mark.parametrize('nap', [0.0, 0.3, 0.1])\ndef test_nap(nap): time.sleep(nap)\n"
    )
    code, out = run({"test": 0.1}, test=f"{sys.executable} -m pytest -q -p no:cacheprovider test_naps.py")
    assert code == 0
    names = [line.split() for line in out.partition("slowest tests [s]")[2].splitlines() if line]
    assert [name for _, name in names] == [f"test_naps::test_nap[{nap}]" for nap in ("0.3", "0.1", "0.0")]
    assert 0.3 <= float(names[0][0]) < 5.0
