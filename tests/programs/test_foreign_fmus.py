"""Foreign FMUs as programs: the same numbers as by hand and as without FMU, energy of the exchange, hostile files."""

import stat
import time
import zipfile
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from tests.generator.c_way import compilers
from tests.programs.foreign_fmu import binary, description, entries_of, write_fmu

from vvdp.base.errors import ConfigError, RunError
from vvdp.cli.main import main
from vvdp.export.fmu import fmu
from vvdp.export.fmu_model import fmu_model
from vvdp.programs.foreign import partners
from vvdp.programs.foreign.archive import MOST_DESCRIPTION
from vvdp.programs.foreign.platforms import this_platform
from vvdp.runs.simulate import run_system
from vvdp.simulation.batch import simulate_batch
from vvdp.simulation.crew import Crew
from vvdp.simulation.run import simulate
from vvdp.systems.system import load_system
from vvdp.workbench.offer import Asked, offer_at

pytestmark = pytest.mark.skipif(not compilers(), reason="no C compiler")
OSCILLATOR = """
title = "A mass whose spring is an FMU"
[nodes]
tank = { type = "tank" }
line = { type = "volume", volume = "1 l", start = "0 bar" }
mass = { type = "rod", mass = "2 kg", velocity = "1 m/s" }
[components]
pump = { type = "flow-source", a = "tank", b = "line", flow = "20 lpm" }
load = { type = "orifice", a = "line", b = "tank", area = "10 mm^2" }
pull = { type = "load-force", rod = "mass", force = { from = "spring.force" } }
[programs.spring]
fmu = "FILE"
inputs = ["v"]
outputs = { force = "joint.F" }
values = { k = "1000 N/m", c = 20.0, mode = 0 }
power = { force = "v" }
reads = { v = "mass.velocity" }
period = "1 ms"
[run]
until = "0.1 s"
sample_period = "1 ms"
record_interval = "1 ms"
window = "0 s"
"""
K, C, MASS = 1000.0, 20.0, 2.0


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """The binaries for FMI 2 and FMI 3."""
    folder = tmp_path_factory.mktemp("foreign")
    return {fmi: binary(folder, fmi) for fmi in (2, 3)}


@pytest.fixture
def system(made, tmp_path, monkeypatch):
    """A function that loads the oscillator with an FMU, and with other words in its text."""
    monkeypatch.setattr(partners, "TRUSTED", set())

    def load(fmi=2, *others, trusted=True, entries=None):
        path = write_fmu(tmp_path / f"spring{fmi}.fmu", entries or entries_of(fmi, made[fmi]))
        text = OSCILLATOR.replace("FILE", path.name)
        for old, new in others:
            assert old in text
            text = text.replace(old, new)
        (tmp_path / "oscillator.toml").write_text(text)
        found = load_system(str(tmp_path / "oscillator.toml"))
        if trusted:
            partners.trust(path)
        return found

    return load


def run_of(system, **others):
    return simulate(system.model, system.case, replace(system.stepping, **others))


def by_hand(period, count, extrapolates=False):
    """Velocities, forces at samples, and the two energies: between samples the force is held, or goes on straight."""
    v, there, force, rate, made, passed = 1.0, 0.0, -C * 1.0, 0.0, 0.0, 0.0
    rows = [(v, force)]
    for _ in range(count):
        end = force + rate * period
        after = v + (0.5 * (force + end)) * period / MASS
        given = 0.5 * (v + after) if extrapolates else after  # the velocity that the FMU is given
        there += period * given
        new = -K * there - C * given
        made += 0.5 * period * (force * v + end * after - given * (force + new))
        passed += 0.5 * period * (abs(force * v) + abs(end * after))
        force, rate, v = new, (new - force) / period if extrapolates else 0.0, after
        rows.append((v, force))
    return np.array(rows), made, passed


@pytest.mark.parametrize("fmi", [2, 3])
def test_motion_is_that_of_the_recursion_by_hand(fmi, system):
    """A mass under a force that is held between samples: velocity and energies, to the tolerance of the run."""
    run = run_of(system(fmi))
    rows, made, passed = by_hand(1e-3, 100)
    assert run.finished and run.times.size == 101
    assert np.abs(run.state.mass.velocity - rows[:, 0]).max() < 1e-9
    assert np.abs(run.command.spring.force[1:] - rows[:-1, 1]).max() < 1e-6  # a row shows what held until then
    memory = run.final_memory["spring"]
    assert memory.exchange == pytest.approx(made, rel=1e-6)
    assert memory.exchanged == pytest.approx(passed, rel=1e-6)


def test_energy_of_a_damper_telescopes(system):
    """F = -c v at each sample: E = c T/2 (v_N^2 - v_0^2), and as m/2 (v_0^2 - v_N^2) passes, a share of -c T/m."""
    run = run_of(system(2, ('"1000 N/m"', "0.0")))
    memory, end = run.final_memory["spring"], run.state.mass.velocity[-1]
    assert memory.exchange == pytest.approx(0.5 * C * 1e-3 * (end**2 - 1.0), rel=1e-6)
    assert memory.exchange / memory.exchanged == pytest.approx(-C * 1e-3 / MASS, rel=0.01)


def test_extrapolated_outputs_go_on_straight(system):
    run = run_of(system(2, ("reads =", "extrapolate = true\nreads =")))
    rows, made, _ = by_hand(1e-3, 100, extrapolates=True)
    assert np.abs(run.state.mass.velocity - rows[:, 0]).max() < 1e-9
    assert run.final_memory["spring"].exchange == pytest.approx(made, rel=1e-5)
    half = ('period = "1 ms"\n[', 'period = "0.5 ms"\n[')
    halved = run_of(system(2, ("reads =", "extrapolate = true\nreads ="), half))
    assert run.final_memory["spring"].exchange / halved.final_memory["spring"].exchange == pytest.approx(4.0, rel=0.1)


def test_sensors_stand_before_the_inputs(system):
    """A resolution of 0.1 m/s: the first force is that of a velocity of 1.0 m/s, the next one of 0.9 or 1.0 m/s."""
    coarse = system(2, ("reads =", 'sensors = { v = { resolution = "0.1 m/s" } }\nreads ='), ('"1000 N/m"', "0.0"))
    forces = run_of(coarse).command.spring.force[1:]
    assert forces[0] == pytest.approx(-C) and len(np.unique(forces.round(9))) < 10
    assert np.abs(forces / (0.1 * C) - np.round(forces / (0.1 * C))).max() < 1e-9


def test_own_process_version_and_threads_have_the_same_bits(system):
    """FMI 2 and FMI 3, in this process and in one of its own, even if the FMU prints; alone and in a batch."""
    one = run_of(system(2))
    others = [
        run_of(system(3)),
        run_of(system(2, ("mode = 0", "mode = 4"), trusted=False)),
        run_of(system(3, trusted=False)),
    ]
    for other in others:
        assert other.states.tobytes() == one.states.tobytes()
    loaded = system(2)
    batch = simulate_batch(loaded.model, [loaded.case] * 5, replace(loaded.stepping, average_from=0.05), Crew(2))
    assert batch.reasons == (None,) * 5
    assert (batch.final == one.final).all()
    assert not partners._slots  # every instance has been ended


def test_an_fmu_for_one_instance_per_process_has_its_own(made, system, monkeypatch):
    monkeypatch.setattr(partners, "Instance", None)  # an instance in this process would fail
    single = entries_of(2, made[2], features='canBeInstantiatedOnlyOncePerProcess="true"')
    assert run_of(system(2, entries=single)).finished
    with pytest.raises(RunError, match="failed at t = 0 s"):
        run_of(system(2))


CONTROLLER = """
title = "A controller alone"
[nodes]
tank = { type = "tank" }
line = { type = "volume", volume = "1 l", start = "0 bar" }
[components]
pump = { type = "flow-source", a = "tank", b = "line", flow = "1 lpm" }
load = { type = "orifice", a = "line", b = "tank", area = "10 mm^2" }
[programs.smooth]
type = "low-pass"
reads = "0 bar"
time_constant = "10 ms"
[programs.controller]
type = "pi"
reads = "smooth.value"
reference = "50 bar"
gain = "-0.01 1/bar"
reset_time = "50 ms"
lowest = "0"
highest = "1"
[run]
until = "1 s"
sample_period = "1 ms"
"""
PLANT = """
title = "A pressure that a controller holds"
[nodes]
tank = { type = "tank" }
line = { type = "volume", volume = "1 l", start = "0 bar" }
[components]
pump = { type = "flow-source", a = "tank", b = "line", flow = "20 lpm" }
load = { type = "orifice", a = "line", b = "tank", area = "1 mm^2" }
[components.valve]
type = "modulated-two-way-valve"
a = "line"
b = "tank"
duty_ratio = { from = "controller.value" }
frequency = "50 Hz"
natural_frequency = "400 Hz"
stroke = "1 mm"
full_area = "20 mm^2"
[programs.ramp]
type = "rate-limit"
reads = { step = ["0 bar", "50 bar"], at = "0.05 s" }
rise = "200 bar/s"
fall = "200 bar/s"
[run]
until = "0.2 s"
sample_period = "1 ms"
"""
DIRECT = CONTROLLER[CONTROLLER.index("[programs") : CONTROLLER.index("[run]")]
FOREIGN = """
[programs.controller]
fmu = "controller.fmu"
inputs = { pressure = "programs.smooth.reads", reference = "programs.controller.reference" }
outputs = { value = "controller.value" }
pressure = "line.pressure"
reference = "ramp.value"
"""


@pytest.mark.parametrize("fmi", [pytest.param(2, marks=pytest.mark.thorough), 3])
def test_exported_controller_as_foreign_fmu_has_the_bits_of_the_direct_run(fmi, tmp_path):
    """A filter and a PI controller, exported by vvdp, hold a pressure as they do within the system."""
    direct = DIRECT.replace('"0 bar"', '"line.pressure"').replace('"50 bar"', '"ramp.value"')
    for name, text in (("alone", CONTROLLER), ("direct", PLANT + direct), ("foreign", PLANT + FOREIGN)):
        (tmp_path / f"{name}.toml").write_text(text)
    (tmp_path / "controller.fmu").write_bytes(fmu(fmu_model(load_system(str(tmp_path / "alone.toml"))), fmi).content)
    runs = [run_of(load_system(str(tmp_path / f"{name}.toml"))) for name in ("direct", "foreign")]
    assert runs[0].states.tobytes() == runs[1].states.tobytes()
    assert runs[0].command.controller.value.tobytes() == runs[1].command.controller.value.tobytes()
    assert np.ptp(runs[0].command.controller.value) > 0.1


# Failures during a run


@pytest.mark.parametrize(
    ("mode", "trusted", "words"),
    [
        (1, False, "failed at t = 0.052 s: its process crashed (SIGABRT)"),
        (2, False, "failed at t = 0.052 s: fmi2DoStep gave the status error"),
        (2, True, "failed at t = 0.052 s: fmi2DoStep gave the status error"),
        (3, True, "failed at t = 0.001 s: it gave no finite force"),
    ],
)
def test_failure_ends_the_run_and_keeps_what_was_reached(mode, trusted, words, system):
    run = run_of(system(2, ("mode = 0", f"mode = {mode}"), trusted=trusted))
    assert words in run.failed and not run.finished
    reached = float(words.split("= ")[1].split(" ")[0])
    assert run.end == pytest.approx(reached, abs=1e-12)
    assert run.times[-1] == pytest.approx(reached) and np.isfinite(run.states).all()


def test_failure_before_the_first_step_is_an_error(made, system):
    wrong = entries_of(2, made[2], token="{other}")
    with pytest.raises(RunError, match="t = 0 s: it refuses to be instantiated"):
        run_of(system(2, entries=wrong))
    with pytest.raises(RunError, match="its binary cannot be loaded"):
        run_of(system(2, entries=entries_of(2, b"no machine code")))


def test_missing_function_is_named(tmp_path, system):
    with pytest.raises(RunError, match="its binary has no function fmi2DoStep"):
        run_of(system(2, entries=entries_of(2, binary(tmp_path, 2, "-DMISSING"))))


def test_run_with_an_fmu_is_not_continued(system):
    loaded = system(2)
    run = run_of(loaded, until=0.01)
    with pytest.raises(RunError, match="cannot be continued"):
        simulate(loaded.model, loaded.case, loaded.stepping, continue_from=run)


def exit_code(*words):
    with pytest.raises(SystemExit) as left:
        main(list(words))
    return left.value.code


def test_command_line_keeps_results_and_says_why(system, tmp_path, capsys):
    system(2, ("mode = 0", "mode = 1"), trusted=False)
    out = tmp_path / "out"
    assert exit_code("run", str(tmp_path / "oscillator.toml"), "--no-report", "--out", str(out)) == 1
    assert "SIGABRT); writing what was reached" in capsys.readouterr().err
    assert (out / "result.h5").is_file()
    assert exit_code("run", str(tmp_path / "oscillator.toml"), "--trust", str(tmp_path / "other.fmu")) == 2
    assert "no program of the system uses this FMU" in capsys.readouterr().err


def test_saved_run_leads_to_the_fmu_from_anywhere(system, tmp_path, monkeypatch):
    loaded = system(2)
    assert Path(loaded.content["programs"]["spring"]["fmu"]) == tmp_path / "spring2.fmu"


PAGE = Path(__file__).parents[2] / "docs" / "foreign-fmus.md"


@pytest.mark.parametrize(("extrapolates", "low", "high"), [(False, 0.0105, 0.0115), (True, 0.0, 0.0001)])
def test_example_of_the_page(extrapolates, low, high, made, tmp_path):
    """The file of the page runs, with the shares of energy that the page states: 1.1 %, below 0.01 %."""
    text = PAGE.read_text("utf-8").partition("```toml")[2].partition("```")[0]
    (tmp_path / "page.toml").write_text(
        text.replace("period =", f"extrapolate = {str(extrapolates).lower()}\nperiod =", 1)
    )
    write_fmu(tmp_path / "arm.fmu", entries_of(2, made[2]))
    run = run_of(load_system(str(tmp_path / "page.toml")))
    memory = run.final_memory["arm"]
    assert low <= abs(memory.exchange / memory.exchanged) < high


def test_workbench_runs_only_the_fmu_of_the_file_that_it_was_given(system, tmp_path):
    system(2, trusted=False)
    (tmp_path / "other.toml").write_text((tmp_path / "oscillator.toml").read_text().replace("spring2", "./spring3"))
    write_fmu(tmp_path / "spring3.fmu", {})
    offer = offer_at(tmp_path / "oscillator.toml")
    assert offer.system(Asked("oscillator.toml")).model.partners
    with pytest.raises(ConfigError, match=r"'spring3\.fmu' is an FMU with machine code; name the file"):
        offer.system(Asked("other.toml"))


# Files


def test_show_reads_the_description_and_loads_nothing(made, tmp_path, monkeypatch, capsys):
    monkeypatch.setenv("FMU_MARK", str(tmp_path / "loaded"))
    path = write_fmu(tmp_path / "spring.fmu", entries_of(3, made[3]))
    assert exit_code("show", str(path)) == 0
    assert "joint.F" in capsys.readouterr().out
    assert not (tmp_path / "loaded").exists()


HOSTILE = {
    "up": ({"../evil": b"x"}, "an entry '../evil', which would lead out of its folder"),
    "absolute": ({"/etc/evil": b"x"}, "which would lead out of its folder"),
    "entities": ({"modelDescription.xml": description(2, before='<!DOCTYPE a [<!ENTITY b "c">]>').encode()}, "DOCTYPE"),
    "large": ({"modelDescription.xml": b" " * (MOST_DESCRIPTION + 1)}, "modelDescription.xml has 32 MB"),
    "broken": ({"modelDescription.xml": b"<fmiModel"}, "not well-formed XML"),
    "other": ({"modelDescription.xml": b"<html/>"}, "expected the element fmiModelDescription"),
    "version": ({"modelDescription.xml": description(2).replace('"2.0"', '"1.0"').encode()}, "'1.0'; expected 2 or 3"),
    "exchange": ({"modelDescription.xml": description(2, kind="ModelExchange").encode()}, "expected CoSimulation"),
    "tool": (
        {"modelDescription.xml": description(2, features='needsExecutionTool="true"').encode()},
        "only with its tool",
    ),
}


@pytest.mark.parametrize("name", HOSTILE)
def test_hostile_files_are_refused_in_one_sentence(name, made, system):
    """The message stands at the key of the file, and nothing is unpacked."""
    others, words = HOSTILE[name]
    with pytest.raises(ConfigError) as refused:
        system(2, entries={**entries_of(2, made[2]), **others}, trusted=False)
    (fault,) = refused.value.faults
    assert fault.key == "programs.spring.fmu" and fault.line and words in fault.message


def test_platforms_links_and_archives_are_refused(made, system, tmp_path):
    library = {"modelDescription.xml": description(2).encode(), "binaries/win16/spring.dll": b""}
    with pytest.raises(ConfigError, match=f"no binary for {this_platform().folder(2)}; it is for win16"):
        system(2, entries=library, trusted=False)
    with pytest.raises(ConfigError, match="there is none at all"):
        system(2, entries={"modelDescription.xml": description(2).encode()}, trusted=False)
    link = zipfile.ZipInfo("resources/link")
    link.external_attr = (stat.S_IFLNK | 0o777) << 16
    with pytest.raises(ConfigError, match="which is a link"):
        system(2, entries={**entries_of(2, made[2]), link: b"/etc/passwd"}, trusted=False)
    (tmp_path / "spring9.fmu").write_bytes(b"no archive")
    with pytest.raises(ConfigError, match="not a zip archive"):
        system(2, ("spring2.fmu", "spring9.fmu"), trusted=False)
    with pytest.raises(ConfigError, match=r"spring8\.fmu: cannot be read"):
        system(2, ("spring2.fmu", "spring8.fmu"), trusted=False)


@pytest.mark.parametrize(
    ("old", "new", "key", "words"),
    [
        ('"joint.F"', '"joint.G"', "outputs.force", "no variable 'joint.G'; did you mean 'joint.F'?"),
        ('"joint.F"', '"k"', "outputs.force", "'k' is of the causality parameter; expected output"),
        (
            '"joint.F"',
            '{ variable = "joint.F", unit = "bar" }',
            "outputs.force",
            "in N, the table in bar; they contradict",
        ),
        ('"1000 N/m"', '"12 kg"', "values.k", "the FMU has it in N/m"),
        ('force = "v"', 'force = "w"', "power", "expected the name of an output"),
        ('["v"]', '["joint.F"]', "inputs.joint.F", "no plain name"),
        ('outputs = { force = "joint.F" }', "", "outputs", "missing; expected one of joint.F"),
        ("reads =", "extrapolate = 1\nreads =", "extrapolate", "expected true or false"),
        ("reads =", 'type = "pi"\nreads =', "fmu", "and no type"),
    ],
)
def test_wrong_tables_are_refused_at_their_key(old, new, key, words, system):
    with pytest.raises(ConfigError) as refused:
        system(2, (old, new), trusted=False)
    assert any(fault.key == f"programs.spring.{key}" and words in fault.message for fault in refused.value.faults)


def test_units_of_the_fmu_are_converted_and_checked(made, system):
    """A force in kN is 1000 times as large; a pressure cannot pull at a rod."""
    pulled = run_of(
        system(2, ('"1000 N/m"', "1.0"), ("c = 20.0", "c = 0.02"), entries=entries_of(2, made[2], unit="kN"))
    )
    assert np.abs(pulled.state.mass.velocity - by_hand(1e-3, 100)[0][:, 0]).max() < 1e-9
    with pytest.raises(ConfigError, match="force"):
        system(2, ("power = ", "#"), entries=entries_of(2, made[2], unit="bar"), trusted=False)
    with pytest.raises(ConfigError, match="the unit 'furlong' of 'joint"):
        system(2, entries=entries_of(2, made[2], unit="furlong"), trusted=False)


def test_report_names_the_period_that_would_do(system):
    """What the exchange creates is proportional to the period."""
    done = run_system(system(2))
    share = abs(done.number("exchange_share"))
    (words,) = [each for each in done_warnings(done) if "exchange" in each]
    assert share > 1e-3 and f"set the period of the program to {1.0 * 1e-3 / share:.2g} ms" in words


def done_warnings(done):
    from vvdp.evaluation.overview import warnings

    return list(warnings(done.system, done.summary))


@pytest.mark.thorough
def test_exchange_costs_less_than_5_us(system):
    """20 000 exchanges in this process, with the FMU's own time; the least of three, beside 20 000 samples without."""
    loaded = system(2, ("0.1 s", "20 s"), ("c = 20.0", "c = 0.5"))
    without = load_system(str(Path(loaded.folder, "oscillator.toml")), ["programs.spring.period=20 s"])
    took = []
    for each in (loaded, without):
        took.append(min(timed(each) for _ in range(3)))
    assert (took[0] - took[1]) / 20_000 < 5e-6


def timed(system):
    began = time.process_time()
    run_of(system)
    return time.process_time() - began
