"""What `--help` says: every verb in whole sentences, with the same flags, nothing cut and nothing of Python."""

import re

import pytest
import typer.main

from vvdp.cli.main import app

ROOT = typer.main.get_command(app)
WRITE_NO_REPORT = {"plot", "export c", "export fmu", "export web"}
"""Verbs that write something else than a result directory."""


def verbs(command, words=()):
    if not hasattr(command, "commands"):
        return {" ".join(words): command}
    return {
        name: verb for word, inner in command.commands.items() for name, verb in verbs(inner, (*words, word)).items()
    }


VERBS = verbs(ROOT)
GROUPS = [()] + [(word,) for word, command in ROOT.commands.items() if hasattr(command, "commands")]


def flags(verb):
    return {text for option in verb.params for text in option.opts}


@pytest.mark.parametrize("name", VERBS)
def test_every_verb_prints_json(name):
    assert "--json" in flags(VERBS[name])


@pytest.mark.parametrize("name", [name for name, verb in VERBS.items() if "--out" in flags(verb)])
def test_every_verb_that_writes_results_has_the_same_flags(name):
    wanted = {"--force", "--no-report"} if name not in WRITE_NO_REPORT else {"--force"}
    assert wanted - flags(VERBS[name]) == set()


@pytest.mark.parametrize("name", VERBS)
def test_help_is_whole_sentences_without_python(vvdp, name, monkeypatch):
    monkeypatch.setenv("COLUMNS", "200")
    text = vvdp(*name.split(), "--help").out
    assert not re.search(r"[{}<>]|\bx[<>]=|\bOf the \w+\.", re.sub(r'"[^"]*"', "", text)), text
    for option in VERBS[name].params:
        assert re.match(r"[A-Z].*[.]$", option.help), (option.opts, option.help)
        assert "may be repeated" not in option.help


@pytest.mark.parametrize("words", GROUPS, ids=" ".join)
def test_no_summary_is_cut_at_80_columns(vvdp, words, monkeypatch):
    monkeypatch.setenv("COLUMNS", "80")
    summaries = vvdp(*words, "--help").out.partition("Commands:\n")[2].partition("\n\n")[0].splitlines()
    for line in summaries:
        assert re.match(r"  \S+ {2,}[A-Z].*\.$", line), line


def test_verbs_come_in_the_order_of_their_use(vvdp):
    listed = re.findall(r"^  (\w+) {2,}", vvdp("--help").out.partition("Commands:\n")[2], re.MULTILINE)
    computing = ["run", "valve", "map", "rig", "study", "design", "compare", "plot", "export", "estimate"]
    computing += ["observability", "geometry", "cfd", "fit"]
    assert [verb for verb in listed if verb in computing] == computing
    assert listed[: len(computing)] == computing
