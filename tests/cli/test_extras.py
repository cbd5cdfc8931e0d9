"""Verbs whose extra is missing, and `vvdp check`, which lists all extras."""

import json
import re
import sys
import tomllib
from pathlib import Path

import pytest
from tests.words import wording

from vvdp.cli.check import OPENS

PROJECT = tomllib.loads(Path(__file__).parents[2].joinpath("pyproject.toml").read_text(encoding="utf-8"))["project"]


def _files(folder):
    return sorted(path for path in folder.rglob("*") if path.is_file())


@pytest.mark.parametrize(
    ("library", "extra", "arguments"),
    [
        ("manifold3d", "geometry", ["geometry", "prototype"]),
        ("trimesh", "geometry", ["geometry", "prototype"]),
        ("trimesh", "geometry", ["cfd", "rail", "prototype"]),
        ("trimesh", "geometry", ["cfd", "valve", "prototype"]),
        ("casadi", "opt", ["design", "levers", "prototype"]),
        ("OCP", "cad", ["geometry", "prototype", "--step"]),
        ("casadi", "opt", ["design", "prototype", "--minimise", "pressure_drop_total"]),
        ("pymoo", "opt", ["design", "pareto", "prototype"]),
        ("SALib", "opt", ["design", "tolerance", "prototype"]),
        ("pyarrow", "data", ["estimate", "log.parquet", "--edges", "a"]),
        ("nptdms", "daq", ["estimate", "log.tdms", "--edges", "a"]),
        ("asammdf", "daq", ["estimate", "log.mf4", "--edges", "a"]),
        ("ziglang", "web", ["run", "prototype", "--live"]),
        ("distributed", "scale", ["study", "study.toml", "--on", "dask"]),
    ],
)
def test_every_verb_says_in_one_wording_what_to_install(vvdp, here, monkeypatch, library, extra, arguments):
    for name, head in (("log.parquet", b"PAR1"), ("log.tdms", b"TDSm"), ("log.mf4", b"MDF     ")):
        Path(name).write_bytes(head.ljust(64, b"\0"))
    Path("study.toml").write_text(
        'system = "prototype"\noutputs = ["efficiency"]\n[grid]\n"operation.duty_ratio" = [0.4, 0.5]\n'
    )
    left = _files(here)
    monkeypatch.setitem(sys.modules, library, None)
    answer = vvdp(*arguments)
    expected = wording.export.needs_library.format(library=library, extra=extra)
    assert answer.err.strip().splitlines()[-1].endswith(f" {expected}"), answer.err
    assert (answer.code, answer.out) == (1, "")
    assert _files(here) == left


def _packages(requirements):
    return {re.match(r"[\w-]+", line)[0] for line in requirements}


def test_check_lists_every_extra_of_the_package_with_what_it_opens(vvdp, tmp_path, monkeypatch, keys_as_described):
    monkeypatch.setenv("VVDP_CACHE", str(tmp_path / "cache"))
    found = json.loads(vvdp("check", "--json").out)
    keys_as_described("check", found)
    extras = {name: _packages(lines) for name, lines in PROJECT["optional-dependencies"].items() if name != "dev"}
    told = {name: set(part["packages"]) for name, part in found["extras"].items()}
    assert told == extras, "after a change of extras install vvdp anew: pip install --no-deps -e ."
    assert set(found["libraries"]) == _packages(PROJECT["dependencies"])
    assert None not in found["libraries"].values()
    assert all(OPENS.values())


def test_check_says_what_is_missing_and_how_it_is_installed(vvdp, tmp_path, monkeypatch):
    monkeypatch.setenv("VVDP_CACHE", str(tmp_path / "cache"))
    asked = ["numpy>=2.0", "casadi>=3.6; extra == 'opt'", 'no-such-library>=1; extra == "daq"']
    monkeypatch.setattr("importlib.metadata.requires", lambda name: asked)
    answer = vvdp("check")
    assert answer.code == 0, answer.err
    assert wording.show.missing_extra.format(extra="daq") in answer.out
    lines = {line.split()[0]: line for line in answer.out.splitlines() if line.split()}
    assert "no-such-library" in lines["[daq]"] and "missing" in lines["[daq]"]
    assert "casadi" in lines["[opt]"] and "missing" not in lines["[opt]"]


def test_check_fails_where_a_needed_library_is_missing(vvdp, tmp_path, monkeypatch):
    monkeypatch.setenv("VVDP_CACHE", str(tmp_path / "cache"))
    monkeypatch.setattr("importlib.metadata.requires", lambda name: ["numpy>=2.0", "no-such-library>=1"])
    answer = vvdp("check", "--json")
    assert answer.code == 1
    assert json.loads(answer.out)["libraries"]["no-such-library"] is None
