"""docs/keys.md names exactly the keys that there are, with the unit that each key ends in.

What is run here is short; longer verbs are held against the page where they are tested anyway, by `keys_as_described`.
"""

import json
import re
import shlex
from pathlib import Path

import pytest
import typer.main

from vvdp.cli.main import app
from vvdp.evaluation.bench_parts import is_bench
from vvdp.systems.system import load_system, shipped_systems

DOCUMENTS = Path(__file__).parents[2] / "docs"
ENDINGS = {
    "m^3/s": "_m3_s",
    "m^3/rad": "_m3_rad",
    "m^3/s/Pa": "_m3_s_Pa",
    "m^3/(s*Pa^0.5)": "_m3_s_Pa05",
    "rad/s": "_rad_s",
    "mm": "_mm",
    "1/s": "_1_s",
    "m/s": "_m_s",
    "rad": "_rad",
    "rad^2": "_rad2",
    "rad^2/s^3": "_rad2_s3",
    "Pa": "_Pa",
    "Pa*s": "_Pa_s",
    "Hz": "_Hz",
    "dB": "_dB",
    "W": "_W",
    "J": "_J",
    "s": "_s",
    "K": "_K",
    "N": "_N",
    "N*m": "_N_m",
    "N/m": "_N_m",
    "N*s/m": "_N_s_m",
    "rev/s": "_rev_s",
    "m": "_m",
    "m^2": "_m2",
    "m^3": "_m3",
    "kg": "_kg",
    "kg*m^2": "_kg_m2",
    "kg/m^3": "_kg_m3",
    "N*m*s": "_N_m_s",
    "Pa*s/m^3": "_Pa_s_m3",
    "Pa*s^2/m^6": "_Pa_s2_m6",
}
OTHERS = {"1", "text", "list", "true or false", "its own"}


def verbs(command=None, name=""):
    """All verbs of the command line with their commands, those of groups in two words."""
    command = command or typer.main.get_command(app)
    if not hasattr(command, "commands"):
        yield name, command
        return
    for word, inner in command.commands.items():
        yield from verbs(inner, f"{name} {word}".strip())


@pytest.mark.thorough
@pytest.mark.parametrize(("verb", "options"), [("valve", ()), ("run", ("--until", "1.5 s", "--no-report"))])
def test_keys_are_those_described(vvdp, here, keys_as_described, verb, options):
    """Mean powers of the whole machine need a whole period of its cycle."""
    systems = [name for name in shipped_systems() if verb == "run" or is_bench(load_system(name))]
    own = {name: ("--no-report",) for name in systems if name.startswith("displacement-control")}
    found = [json.loads(vvdp(verb, name, "--json", *own.get(name, options)).out) for name in systems]
    keys_as_described(verb, *found)


def test_every_verb_with_json_has_its_keys_described(key_sections):
    printing = {name for name, verb in verbs() if any("--json" in option.opts for option in verb.params)}
    assert len(printing) > 12
    assert printing | {""} == set(key_sections)


def test_keys_end_in_their_unit(key_sections):
    for verb, section in key_sections.items():
        for key, (unit, *_) in section.rows.items():
            assert unit in ENDINGS or unit in OTHERS, (verb, key, unit)
            if unit != "its own":
                longest = max((e for e in ENDINGS.values() if key.endswith(e)), key=len, default="")
                assert longest == ENDINGS.get(unit, ""), (verb, key)


def test_every_verb_is_in_the_guide():
    guide = (DOCUMENTS / "command-line.md").read_text("utf-8")
    missing = {name.split()[0] for name, _ in verbs()} - set(re.findall(r"^## `vvdp ([a-z]+)`$", guide, re.MULTILINE))
    assert not missing


def example(command: str) -> list[str]:
    """The lines that the guide shows after `command`, without what it leaves out."""
    guide = (DOCUMENTS / "command-line.md").read_text("utf-8")
    shown = re.split(r"\n(?=[^ \n])", guide.partition(f"    $ {command}\n")[2], maxsplit=1)[0]
    lines = [line.strip() for line in shown.splitlines()]
    return [line for line in lines if line and "..." not in line]


@pytest.mark.parametrize(
    "command",
    [
        'vvdp valve prototype --flow "40 lpm" --temperature "40 degC"',
        "vvdp show prototype",
        "vvdp new my-pump --from prototype",
        "vvdp list",
        "vvdp export c prototype --part estimate --out estimate",
    ],
)
def test_the_examples_of_the_guide_are_real(vvdp, here, command):
    if command == "vvdp list":
        vvdp("new", "my-pump", "--from", "prototype")
    said = [line.strip() for line in vvdp(*shlex.split(command)[1:]).out.splitlines()]
    lines = example(command)
    assert lines
    assert [line for line in lines if line not in said] == []


@pytest.mark.thorough
def test_the_run_of_the_guide_shows_what_a_run_shows(vvdp, here):
    answer = vvdp("run", "prototype", "--until", "0.52 s", "--no-report", "--out", "out")
    labels = {line.strip().partition("  ")[0] for line in answer.out.splitlines()}
    lines = example("vvdp run prototype --set operation.duty_ratio=0.4 --out results/duty-0.4")
    quantities = [line.partition("  ")[0] for line in lines if "  " in line]
    assert len(quantities) > 15
    assert set(quantities) <= labels


@pytest.mark.thorough
def test_the_examples_on_results_are_real(vvdp, here, is_shown):
    """`vvdp compare runs`, `vvdp plot` and `vvdp export data`, on the two runs that the guide has."""
    guide = (DOCUMENTS / "command-line.md").read_text("utf-8")
    for duty in ("0.4", "0.6"):
        words = ("--set", f"operation.duty_ratio={duty}", "--out", f"results/duty-{duty}", "--no-report")
        assert vvdp("run", "prototype", *words).code == 0
    blocks = re.findall(
        r"^    \$ vvdp ((?:compare runs|plot|export data) .*)\n((?:    (?!\$).*\n|\n)*)", guide, re.MULTILINE
    )
    assert len(blocks) == 4
    for command, shown in blocks:
        answer = vvdp(*shlex.split(command))
        assert answer.code == 0, answer.err
        assert is_shown(re.sub("^    ", "", shown, flags=re.MULTILINE), answer.out), command
