"""`vvdp list`, `show`, `new`, `check` and `--version`."""

import json
from pathlib import Path

import pytest
from tests.words import wording

import vvdp as package
from vvdp.systems.system import load_system, shipped_systems


def test_version_and_bare_call(vvdp):
    assert vvdp("--version").out == f"vvdp {package.__version__}\n"
    bare = vvdp()
    assert "Commands:" in bare.out + bare.err


def test_help_of_every_verb_says_what_it_does(vvdp):
    for verb in ("run", "valve", "study", "list", "show", "new", "report", "check"):
        assert vvdp(verb, "--help").code == 0
    first_lines = vvdp("--help").out
    assert "..." not in first_lines.partition("Commands:")[2]


def test_list_names_shipped_systems_and_those_in_the_folder(vvdp, here):
    assert wording.show.systems_in_folder not in vvdp("list").out
    vvdp("new", "mine", "--from", "prototype")
    (here / "pyproject.toml").write_text("[project]\nname = 'x'\n")
    (here / "broken.toml").write_text("[")
    (here / "folder.toml").mkdir()
    listed = vvdp("list")
    assert listed.code == 0 and wording.show.systems_in_folder in listed.out
    for name, text in shipped_systems().items():
        assert name in listed.out
        assert text.partition('title = "')[2].partition('"')[0] in listed.out
    assert "mine.toml" in listed.out
    for other in ("pyproject", "broken", "folder.toml"):
        assert other not in listed.out


@pytest.mark.sampled(4)
@pytest.mark.parametrize("name", list(shipped_systems()))
def test_show_names_every_value_with_its_origin(vvdp, name):
    shown, system = vvdp("show", name), load_system(name)
    assert shown.code == 0
    lines = shown.out.splitlines()
    for row in system.rows:
        told = [line for line in lines if row.display_text in line and line.split()[0] == row.key]
        assert any(row.status in line and row.note in line for line in told), row
    assert wording.show.assumed.format(assumed=len(system.assumptions), values=len(system.rows)) in shown.out
    for row in system.assumptions:
        assert f"{row.table}.{row.key}" in shown.out.splitlines()[-1]


def test_pressure_levels_are_shown_both_ways(vvdp):
    assert "120 bar (121.013 bara)" in vvdp("show", "prototype").out


def test_show_as_json(vvdp):
    found = json.loads(vvdp("show", "prototype", "--json", "--set", "relief_valve.cracking_pressure=130 bar").out)
    entry = found["parameters"]["relief_valve.cracking_pressure"]
    assert entry["value"] == pytest.approx(130e5 + 101325.0)
    assert entry["unit"] == "Pa"
    assert entry["status"] == "given"
    assumed = {key for key, e in found["parameters"].items() if e["status"] == "assumed"}
    idle = {"pump.ripple_count", "operation.spool_motor_speed"}  # the amplitude is 0, and so is the coupling
    assert assumed - set(found["assumed"]) == idle


def test_show_of_a_value_that_changes(vvdp):
    step = 'operation.pump_speed={step = ["1200 rpm", "1800 rpm"], at = "0.5 s"}'
    found = json.loads(vvdp("show", "prototype", "--json", "--set", step).out)["parameters"]["operation.pump_speed"]
    assert found["value"] is None
    assert found["low"] == pytest.approx(125.66370614)
    assert found["high"] == pytest.approx(188.49555922)


def test_new_copies_with_comments_and_another_title(vvdp, here):
    answer = vvdp("new", "mine", "--from", "prototype")
    assert answer.out == wording.show.new_written.format(file="mine.toml") + "\n"
    source, text = shipped_systems()["prototype"].splitlines(), (here / "mine.toml").read_text().splitlines()
    assert [line for line in text if line not in source] == ['title = "mine"']
    assert len(text) == len(source)
    assert load_system("mine.toml").case == load_system("prototype").case


def test_new_copies_the_system_whose_name_a_program_has_too(vvdp, here):
    assert vvdp("new", "mine", "--from", "displacement-control").code == 0
    source, text = shipped_systems()["displacement-control"].splitlines(), (here / "mine.toml").read_text().splitlines()
    assert [line for line in text if line not in source] == ['title = "mine"'] and len(text) == len(source)
    assert vvdp("new", "example", "--from", "period-average").code == 0
    assert (here / "example.toml").read_text().count("\n") == 158  # as docs/programs.md says


def test_new_from_a_file(vvdp, here):
    vvdp("new", "first", "--from", "prototype-constant-load")
    assert vvdp("new", "second.toml", "--from", "first.toml").code == 0
    assert load_system("second.toml").title == "second"


@pytest.mark.parametrize("name", ['with "quotes"', "back\\slash", "Kölbchen 3"])
def test_new_with_an_odd_name(vvdp, here, name):
    assert vvdp("new", name, "--from", "prototype").code == 0
    assert load_system(f"{name}.toml").title == name


def test_new_overwrites_only_when_told(vvdp, here):
    (here / "mine.toml").write_text("precious")
    refused = vvdp("new", "mine", "--from", "prototype")
    assert refused.code == 2
    assert wording.files.already_exists in refused.err
    assert (here / "mine.toml").read_text() == "precious"
    assert vvdp("new", "mine", "--from", "prototype", "--force").code == 0
    assert load_system("mine.toml")


@pytest.mark.parametrize(
    ("name", "source"),
    [
        ("nowhere/mine", "prototype"),
        ("mine", "protoype"),
        ("mine", "broken.toml"),
        ("", "prototype"),
        ("a\nb", "prototype"),
    ],
)
def test_new_refuses(vvdp, here, name, source):
    (here / "broken.toml").write_text("circuit = 3\n")
    refused = vvdp("new", name, "--from", source)
    assert refused.code == 2
    assert refused.err
    assert [p.name for p in here.iterdir()] == ["broken.toml"]


def test_a_title_over_several_lines_stays(vvdp, here):
    text = (
        shipped_systems()["prototype"]
        .replace('title = "', 'title = """\nlong ')
        .replace('load"\n\n[nodes]', 'load"""\n\n[nodes]')
    )
    (here / "long.toml").write_text(text)
    assert vvdp("new", "mine", "--from", "long.toml").code == 0
    assert load_system("mine.toml").title == load_system("long.toml").title


def test_check_tells_what_is_there(vvdp, tmp_path, monkeypatch):
    monkeypatch.setenv("VVDP_CACHE", str(tmp_path / "cache"))
    answer = vvdp("check")
    assert answer.code == 0, answer.err
    assert wording.show.writable.format(folder=tmp_path / "cache") in answer.out
    for part in ("python", "llvmlite", "casadi", "chromium", "openfoam", "slurm"):
        assert f" {part} " in answer.out


def test_check_fails_where_the_cache_cannot_be_written(vvdp, tmp_path, monkeypatch):
    (tmp_path / "file").write_text("")
    monkeypatch.setenv("VVDP_CACHE", str(tmp_path / "file" / "cache"))
    answer = vvdp("check")
    assert answer.code == 1
    assert wording.show.not_writable in answer.out


def test_check_finds_programs_on_the_path(vvdp, tmp_path, monkeypatch):
    program = Path(tmp_path, "simpleFoam")
    program.write_text("#!/bin/sh\n")
    program.chmod(0o755)
    monkeypatch.setenv("PATH", str(tmp_path))
    found = vvdp("check").out
    assert str(program) in found
    assert wording.show.not_found in next(line for line in found.splitlines() if line.split()[:1] == ["slurm"])


@pytest.mark.parametrize(
    "command",
    [
        "geometry prototype --fineness 10 --frames 0",
        "design temperature prototype --from 38degC --to 42degC",
        "compare estimators --seeds 1 --scenario step --estimator m-over-t",
    ],
)
def test_without_a_report_there_is_none(vvdp, here, command):
    answer = vvdp(*command.split(), "--no-report", "--out", "r")
    assert answer.code == 0, answer.err
    assert "report" not in answer.out
    assert (here / "r" / "meta.json").is_file()
    assert not (here / "r" / "report.html").exists()


def test_verbs_that_list_and_write_print_json(vvdp, here):
    assert json.loads(vvdp("new", "mine", "--from", "prototype", "--json").out) == {
        "system": "mine",
        "out": "mine.toml",
        "parts": [],
    }
    listed = json.loads(vvdp("list", "--json").out)
    assert "prototype" in listed["systems"]
    assert listed["files"]["mine.toml"]["title"] == "mine"
    library = json.loads(vvdp("list", "--components", "--json").out)
    assert library["nodes"].keys() & {"volume", "tank"}
    assert "diameter" in str(library["components"]["orifice"]["values"]) + str(library["components"])
    assert json.loads(vvdp("check", "--json").out)["vvdp"]
