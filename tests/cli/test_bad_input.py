"""What a person may get wrong: each is told in one line per fault, with exit code 2, and never with a traceback."""

import os
import re

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from vvdp.systems.system import shipped_systems

PROTOTYPE = shipped_systems()["prototype"]


@pytest.fixture
def refused(vvdp):
    """The lines told about arguments that must be refused."""

    def call(*arguments: str) -> list[str]:
        answer = vvdp(*arguments)
        assert answer.code == 2
        assert not answer.out
        assert "Traceback" not in answer.err
        return answer.err.splitlines()

    return call


@pytest.fixture
def edited(here):
    """A file with one line of the prototype replaced, and the number of that line."""

    def write(old: str, new: str) -> int:
        assert PROTOTYPE.count(old) == 1
        (here / "my.toml").write_text(PROTOTYPE.replace(old, new))
        return PROTOTYPE[: PROTOTYPE.index(old)].count("\n") + 1

    return write


EDITS = [
    (
        "unknown key",
        "[pump]\n",
        '[pump]\ndisplacment = "22.8 cc/rev"\n',
        "pump.displacment",
        "did you mean 'displacement'",
    ),
    ("missing unit", 'volume = { value = "12.7 cc"', 'volume = { value = "12.7"', "inlet.volume", "has no unit"),
    (
        "wrong dimension",
        'volume = { value = "12.7 cc"',
        'volume = { value = "12.7 bar"',
        "inlet.volume",
        "is not a volume",
    ),
    (
        "speed as frequency",
        'spool_speed = { value = "1475 rpm"',
        'spool_speed = { value = "20 Hz"',
        "initial.spool_speed",
        "rpm",
    ),
    (
        "unknown unit",
        'volume = { value = "12.7 cc"',
        'volume = { value = "12.7 cubits"',
        "inlet.volume",
        "unknown unit",
    ),
    (
        "out of range",
        'oil_temperature = { value = "40 degC"',
        'oil_temperature = { value = "400 degC"',
        "operation.oil_temperature",
        "outside",
    ),
    (
        "no finite number",
        'volume = { value = "12.7 cc"',
        'volume = { value = "1e999 cc"',
        "inlet.volume",
        "not a finite number",
    ),
    ("a list", 'volume = { value = "12.7 cc"', 'volume = { value = ["12.7 cc"]', "inlet.volume", "is not a volume"),
    (
        "unknown status",
        'rated_power = { value = "5.6 kW", status = "published"',
        'rated_power = { value = "5.6 kW", status = "guessed"',
        "motor.rated_power",
        "guessed",
    ),
]


@pytest.mark.parametrize(("old", "new", "key", "said"), [edit[1:] for edit in EDITS], ids=[edit[0] for edit in EDITS])
def test_a_fault_in_a_file_is_told_with_its_line(edited, refused, old, new, key, said):
    line = edited(old, new) + ("\n" in old)
    lines = refused("show", "my.toml")
    assert len(lines) == 1
    assert lines[0].startswith(f"my.toml:{line}: {key}: ")
    assert said in lines[0]


def test_an_unknown_table_circuit_or_method(edited, refused):
    edited("[motor]\n", "[engine]\n")
    lines = refused("show", "my.toml")
    assert any("engine" in line and "unknown table" in line for line in lines)
    assert any("motor: missing table" in line for line in lines)
    edited('circuit = "orifice-load"', 'circuit = "other"')
    assert "'other' is not a circuit" in refused("show", "my.toml")[0]
    edited('until = "1 s"', 'until = "1 s"\nmethod = "fast"')
    assert "'fast'" in refused("show", "my.toml")[0]


def test_duty_ratio_and_axial_position_contradict(edited, refused):
    line = edited("duty_ratio = { value", 'axial_position = "10 mm"\nduty_ratio = { value')
    lines = refused("run", "my.toml")
    assert lines == [f"my.toml:{line}: operation.axial_position: contradicts operation.duty_ratio; give one of the two"]


def test_several_faults_are_all_told(here, refused):
    text = PROTOTYPE.replace('"12.7 cc"', '"12.7"').replace('"876 kg/m^3"', '"876 bar"').replace('"5.6 kW"', '"-3 kW"')
    (here / "my.toml").write_text(text)
    lines = refused("run", "my.toml", "--until", "0.1 s")
    assert [line.split(": ")[1] for line in lines] == ["oil.density", "motor.rated_power", "inlet.volume"]


@pytest.mark.parametrize(
    ("content", "said"),
    [
        (b"", "is empty"),
        (b"# nothing\n", "is empty"),
        (b"\xff\xfe\x00[", "is not UTF-8"),
        (b'title = "a"\n[oil\ndensity = 3\n', "my.toml:2: is not valid TOML"),
        (b"a = 1\na = 2\n", "is not valid TOML"),
        (
            b"p = { flow = 20 lpm }\n",
            'my.toml:1: is not valid TOML: Unclosed inline table; a value with a unit stands in quotes: "20 lpm"',
        ),
        (b"a = " + b"[" * 20_000, "is not valid TOML"),
        (b"a = " + b"9" * 20_000, "is not valid TOML"),
        (b"#" * 1_000_001, "1000001 bytes"),
        (b"oil = 3\n", "circuit: missing"),
        (b'circuit = "orifice-load"\noil = 3\n', "3 is not a table"),
        (b'circuit = ["orifice-load"]\n', "is not a circuit"),
        (b'circuit = "orifice-load"\nrun = 3\n', "run: 3 is not a table"),
        (b"\x00\x01", "is not valid TOML"),
    ],
)
@pytest.mark.parametrize("verb", [("show",), ("run", "--until", "0.1 s"), ("valve", "--set", "inlet.volume=1 cc")])
def test_files_that_are_no_systems(here, refused, content, said, verb):
    (here / "my.toml").write_bytes(content)
    lines = refused(verb[0], "my.toml", *verb[1:])
    assert any(said in line for line in lines), lines
    assert all(line.startswith("my.toml") for line in lines)


def test_a_number_beyond_floats(here, refused):
    huge = "0x" + "f" * 5000
    (here / "my.toml").write_text(PROTOTYPE.replace('{ value = "12.7 cc"', f"{{ value = {huge}"))
    assert "too large" in refused("show", "my.toml")[0]


def test_a_unit_that_would_take_hours_to_work_out(refused):
    assert "unknown unit" in refused("show", "prototype", "--set", "inlet.volume=1 m^9^9^9^9")[0]


def test_places_that_are_no_files(here, refused, monkeypatch):
    assert "neither a shipped system" in refused("run", "protoype")[0]
    assert "no such file" in refused("run", "protoype.toml")[0]
    assert "is a directory" in refused("run", str(here))[0]
    assert "neither" in refused("run", "x" * 5000)[0]
    assert "cannot be read" in refused("run", "x" * 5000 + ".toml")[0]
    assert "neither" in refused("run", "")[0] or "directory" in refused("run", "")[0]
    assert "not a regular file" in refused("run", "/dev/zero")[0]
    os.mkfifo("pipe.toml")
    assert "not a regular file" in refused("run", "pipe.toml")[0]
    (here / "loop.toml").symlink_to("loop.toml")
    assert "cannot be read" in refused("run", "loop.toml")[0]


def test_a_file_that_may_not_be_read(here, refused, monkeypatch):
    (here / "my.toml").write_text(PROTOTYPE)

    def denied(self):
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr("pathlib.Path.read_bytes", denied)
    assert refused("show", "my.toml") == ["my.toml: cannot be read (Permission denied)"]


@pytest.mark.parametrize(
    ("setting", "said"),
    [
        ("inlet.volume", "expected table.key"),
        ("=3 cc", "expected table.key"),
        ("inlet.volume=", "expected table.key"),
        ("volume=3 cc", "expected table.key"),
        ("duty_ratio=1.4", "duty_ratio=1.4: expected table.key"),
        ("duty_ratio=1.4", "did you mean 'operation.duty_ratio=1.4'?"),
        ("a.b.c=3 cc", "--set: a: unknown table"),
        ("inlet.volum=3 cc", "did you mean 'volume'"),
        ("inlets.volume=3 cc", "unknown table"),
        ("inlet.volume=3 bar", "is not a volume"),
        ("inlet.volume={step=", "not valid TOML"),
        ("inlet.volume={step=['1 cc','2 cc'], at='1 s'}", "does not change"),
        ("operation.duty_ratio={ramp=['0','1'], from='1 s', to='0 s'}", "before it begins"),
        ("operation.duty_ratio={table=[['1 s','0'],['0 s','1']]}", "backwards"),
        ("title.a=3", "'title' is not a table"),
        ("operation.axial_position=10 km", "is outside"),
    ],
)
def test_bad_settings(refused, setting, said):
    lines = refused("show", "prototype", "--set", setting)
    assert any(said in line for line in lines), lines


def test_a_value_of_the_command_line_is_not_blamed_on_the_file(refused):
    lines = refused("show", "prototype", "--set", "inlet.volume=3 bar", "--set", "pump.speed=3 rpm")
    assert all(line.startswith("--set: ") for line in lines)
    assert len(lines) == 2


@pytest.mark.parametrize("until", ["abc", "0 s", "-1 s", "1", "1 bar", "nan s", "", "1e9 s", "5e5 s"])
def test_bad_durations(refused, here, until):
    lines = refused("run", "prototype", "--until", until)
    assert len(lines) == 1
    assert not list(here.iterdir())


def test_unusable_output_directories(refused, here):
    (here / "file").write_text("")
    (here / "full").mkdir()
    (here / "full" / "thesis.tex").write_text("")
    short = ("run", "prototype", "--until", "0.01 s", "--no-report", "--out")
    assert "cannot be written (File exists: " in refused(*short, "file/below")[0]
    assert "cannot be written" in refused(*short, "/proc/below")[0]
    assert "cannot be written" in refused(*short, "x" * 300)[0]
    assert "already exists" in refused(*short, "file")[0]
    assert "is not a directory" in refused(*short, "file", "--force")[0]
    assert "already exists" in refused(*short, "full")[0]
    assert "something else than results" in refused(*short, "full", "--force")[0]
    assert "something else than results" in refused(*short, ".", "--force")[0]
    assert sorted(p.name for p in here.iterdir()) == ["file", "full"]
    assert (here / "full" / "thesis.tex").exists()


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("fly",), "No such command 'fly'"),
        (("run",), "Missing argument"),
        (("run", "prototype", "--fast"), "No such option"),
        (("run", "prototype", "extra"), "unexpected extra argument"),
        (("run", "prototype", "--until"), "requires an argument"),
        (("new", "mine"), "Missing option"),
        (("--nonsense",), "No such option"),
        (("report", "nowhere"), "no such directory"),
    ],
)
def test_bad_verbs_and_options(refused, here, arguments, said):
    assert said in "\n".join(refused(*arguments))


SNIPPETS = st.one_of(
    st.text(max_size=12),
    st.sampled_from(
        ["=", "{", "}", "[", "]", '"', "\n", "[[", "'''", '"""', ".", "-", "0", "9" * 30, " bar", "nan", "inf", "1e999"]
    ),
    st.sampled_from(
        ["[oil]\n", "[valve]\n", "value = ", "status", "true", "1979-05-27", "{ step = [", "\\u0000", "#", "\x00"]
    ),
)


@st.composite
def mutilated(draw):
    text = PROTOTYPE
    for _ in range(draw(st.integers(1, 4))):
        start = draw(st.integers(0, len(text)))
        end = min(len(text), start + draw(st.sampled_from([0, 0, 1, 2, 5, 30, 400])))
        text = text[:start] + draw(SNIPPETS) + text[end:]
    return text


@pytest.mark.thorough
@settings(max_examples=120, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(text=mutilated())
def test_a_mutilated_file_is_shown_or_refused(here, vvdp, text):
    (here / "my.toml").write_bytes(text.encode("utf-8", "surrogatepass"))
    answer = vvdp("show", "my.toml")
    assert answer.code in (0, 2)
    assert (answer.code == 0) == bool(answer.out)
    assert (answer.code == 2) == bool(answer.err)


@pytest.mark.thorough
@settings(max_examples=80, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.text(st.characters(exclude_categories=("Cs",), exclude_characters="\x00"), max_size=30))
def test_any_text_as_a_value(vvdp, text):
    assert vvdp("valve", "prototype", "--json", "--set", f"operation.duty_ratio={text}").code in (0, 2)
    assert vvdp("valve", "prototype", "--json", "--flow", f"{text}").code in (0, 2)


@pytest.mark.parametrize(
    ("command", "meant"),
    [
        ("run protoype", "'prototype'"),
        ("rn prototype", "'run'"),
        ("rig presure-drop prototype", "'pressure-drop'"),
        ("design pareo prototype", "'pareto'"),
        ("compare estimators --estimator event-fliter", "'event-filter'"),
        ("run prototype --set operation.duty_rato=0.4", "'duty_ratio'"),
        ("run prototype --set operatin.duty_ratio=0.4", "'operation'"),
        ("run prototype --set duty_ratio=0.4", "'operation.duty_ratio=0.4'"),
        ("valve prototype --flw 40lpm", "--flow"),
    ],
)
def test_a_slip_is_answered_with_what_was_meant(vvdp, here, command, meant):
    answer = vvdp(*command.split())
    assert answer.code == 2
    assert re.search(rf"[Dd]id you mean {re.escape(meant)}\?|Possible options: {re.escape(meant)}\)", answer.err), (
        answer.err
    )
    assert list(here.iterdir()) == []
