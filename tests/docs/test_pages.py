"""What holds for all pages: commands are commands; README's links lead somewhere, its figures are those of a run."""

import json
import re
import shlex
from pathlib import Path

import typer.main

import vvdp
from vvdp.cli.main import app
from vvdp.evaluation.summary import summary
from vvdp.generator.source import known_text
from vvdp.simulation.run import simulate
from vvdp.systems.system import load_system
from vvdp.valve.geometry import transition_fraction

ROOT = Path(__file__).parents[2]
README = (ROOT / "README.md").read_text("utf-8")
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]
LINK = re.compile(r"(?<!`)\[[^\]`]*(?:`[^`]*`)?[^\]]*\]\(([^)\s]+)\)")
COMMAND = re.compile(r"^(?: {4}\$ | {4}|\$ )?vvdp ([a-z].*)$", re.MULTILINE)
USAGE_ERROR = typer.BadParameter.__bases__[0]


def commands(page: Path) -> list[str]:
    """Lines of a page that begin with vvdp inside a block of code."""
    text = page.read_text("utf-8")
    blocks = re.findall(r"^```(?:sh|)\n(.*?)^```", text, re.DOTALL | re.MULTILINE)
    blocks += re.findall(r"(?:^ {4}.*\n)+", text, re.MULTILINE)
    return [line.replace("\\", "") for block in blocks for line in COMMAND.findall(block)]


def usage_problem(line: str) -> str:
    """What the command line would refuse of a command, without running it; empty where that is nothing."""
    words = shlex.split(re.split(r"\s#\s|  +", line)[0], comments=True)
    command = typer.main.get_command(app)
    context = command.context_class(command, info_name="vvdp")
    try:
        while hasattr(command, "commands"):
            command.parse_args(context, words)
            _, inner, words = command.resolve_command(context, [*context._protected_args, *context.args])
            assert inner is not None
            command, context = inner, inner.context_class(inner, parent=context)
        _, rest, _ = command.make_parser(context).parse_args(list(words))
    except USAGE_ERROR as problem:
        return f"{line}: {problem.format_message()}"
    return f"{line}: too much: {rest}" if rest else ""


def test_every_command_of_every_page_is_one():
    lines = [line for page in PAGES for line in commands(page)]
    assert len(lines) > 60
    assert [problem for line in lines if (problem := usage_problem(line))] == []
    assert (
        usage_problem("run prototype --untl 1") and usage_problem("rnu prototype") and usage_problem("show this that")
    )


def test_every_command_has_its_time():
    """Each in one row of the table, a group by its members or as a whole."""
    page = (ROOT / "docs" / "command-line.md").read_text("utf-8")
    table = page.partition("## How long commands take")[2].partition("\n## ")[0]
    listed = re.findall(r"`([a-z][a-z -]*)`", "".join(line for line in table.splitlines() if line.startswith("| ")))
    listed = [each for each in listed if each != "design"]  # the same as `design optimum`
    assert len(listed) == len(set(listed))
    known = typer.main.get_command(app).commands
    assert {each.split()[0] for each in listed} == set(known) - {"completion"}
    for name in ("design", "rig", "compare", "export"):
        inner = {f"{name} {each}" for each in known[name].commands}
        assert inner == {each for each in listed if each.startswith(f"{name} ")}, name


def test_links_of_the_readme_lead_somewhere():
    """Those of the other pages are held by the build of the site."""
    links = LINK.findall(re.sub(r"```.*?```", "", README, flags=re.DOTALL))
    assert len(links) > 25
    assert [link for link in links if not re.match(r"[a-z]+:", link) and not (ROOT / link).exists()] == []


def test_the_first_run_ends_as_the_readme_says():
    section = README.partition("## How the first run ends\n")[2].partition("\n## ")[0]
    system = load_system("prototype")
    found = summary(system, simulate(system.model, system.case, system.stepping))
    said = {
        r"duty ratio ([\d.]+)": 0.5,
        r"takes ([\d ]+) steps": round(found["steps"], -3),
        r"at ([\d.]+) Hz": round(found["pwm_frequency_Hz"], 1),
        r"([\d.]+) lpm of": round(found["mean_load_flow_m3_s"] * 6e4, 1),
        r"at (\d+) bar": round(found["pressure_mean_load_line_Pa"] / 1e5),
        r"of the ([\d.]+) kW": round(found["input_power_W"] / 1e3, 1),
        r"([\d.]+) % of the [\d.]+ kW": round(100.0 * found["efficiency"], 1),
        r"take (\d+) W and": round(found["loss_nozzle_W"], -1),
        r"during (\d+) % of each": round(200.0 * transition_fraction(system.case.params.valve), -1),
        r"relief valve (\d+) W": round(found["loss_relief_valve_W"], -1),
    }
    for pattern, value in said.items():
        assert float(re.search(pattern, " ".join(section.split()))[1].replace(" ", "")) == value, pattern


def test_the_script_of_the_readme_runs(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (script,) = re.findall(r"```python\n(.*?)```", README, re.DOTALL)
    exec(compile(script, known_text(script, "README.md"), "exec"), {})
    said = re.search(r"It prints (\d+) W and `True`. A run of 0.5 s prints (\d+) W and `False`", README)
    power, settled = capsys.readouterr().out.split()
    assert round(float(power)) == int(said[1]) and settled == "True"
    short = vvdp.load("prototype", operation={"duty_ratio": 0.4}).run(until="0.5 s").summary
    assert round(short["load_power_W"], -1) == int(said[2]) and not short["settled"]
    assert (tmp_path / "load.png").stat().st_size > 1000


def test_no_documented_output_holds_nan():
    """A number that is not known stands on a page with its reason, or not at all."""
    printed = {
        path.name: [
            "".join(output.get("text", [])) + "".join(output.get("data", {}).get("text/plain", []))
            for cell in json.loads(path.read_text("utf-8"))["cells"]
            for output in cell.get("outputs", [])
        ]
        for path in (ROOT / "docs" / "notebooks").glob("*.ipynb")
    }
    assert len(printed) >= 5 and all(map(any, printed.values()))
    assert [name for name, texts in printed.items() if re.search(r"\bnan\b", "".join(texts))] == []
    blocks = {page.name: re.findall(r"(?:^ {4}.*\n)+", page.read_text("utf-8"), re.MULTILINE) for page in PAGES}
    assert [name for name, found in blocks.items() if re.search(r"\bnan\b", "".join(found))] == []
