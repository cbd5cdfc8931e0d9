"""What a person may get wrong: each is told in one line per fault, with exit code 2, and never with a traceback."""

import os
import re

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from tests.words import wording

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
        wording.files.did_you_mean.format(name="displacement"),
    ),
    (
        "missing unit",
        'volume = { value = "12.7 cc"',
        'volume = { value = "12.7"',
        "inlet.volume",
        wording.files.has_no_unit,
    ),
    (
        "wrong dimension",
        'volume = { value = "12.7 cc"',
        'volume = { value = "12.7 bar"',
        "inlet.volume",
        wording.files.is_not_a.format(quantity="a volume"),
    ),
    (
        "speed as frequency",
        'spool_speed = { value = "1475 rpm"',
        'spool_speed = { value = "20 Hz"',
        "initial.spool_speed",
        "rpm",
    ),
    (
        wording.files.unknown_unit,
        'volume = { value = "12.7 cc"',
        'volume = { value = "12.7 cubits"',
        "inlet.volume",
        wording.files.unknown_unit,
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
        wording.files.is_not_finite,
    ),
    (
        "a list",
        'volume = { value = "12.7 cc"',
        'volume = { value = ["12.7 cc"]',
        "inlet.volume",
        wording.files.is_not_a.format(quantity="a volume"),
    ),
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
    assert any("engine" in line and wording.files.unknown_table in line for line in lines)
    line = edited("[nodes]\n", 'circuit = "other"\n[nodes]\n')
    assert refused("show", "my.toml") == [f"my.toml:{line}: circuit: this file draws its circuit; remove this line"]
    edited('until = "1 s"', 'until = "1 s"\nmethod = "fast"')
    assert "'fast'" in refused("show", "my.toml")[0]


def test_duty_ratio_and_axial_position_contradict(edited, refused):
    line = edited("duty_ratio = { value", 'axial_position = "10 mm"\nduty_ratio = { value') + 1
    lines = refused("run", "my.toml")
    assert lines == [
        f"my.toml:{line}: operation.duty_ratio: "
        + wording.files.contradicts.format(key="axial_position")
        + wording.files.give_one
    ]


def test_several_faults_are_all_told(here, refused):
    text = PROTOTYPE.replace('"12.7 cc"', '"12.7"').replace('"876 kg/m^3"', '"876 bar"').replace('"5.6 kW"', '"-3 kW"')
    (here / "my.toml").write_text(text)
    lines = refused("run", "my.toml", "--until", "0.1 s")
    assert [line.split(": ")[1] for line in lines] == ["oil.density", "inlet.volume", "motor.rated_power"]


@pytest.mark.parametrize(
    ("content", "said"),
    [
        (b"", wording.files.is_empty),
        (b"# nothing\n", wording.files.is_empty),
        (b"\xff\xfe\x00[", wording.files.is_not_utf8),
        (b'title = "a"\n[oil\ndensity = 3\n', "my.toml:2: " + wording.files.is_not_toml),
        (b"a = 1\na = 2\n", wording.files.is_not_toml),
        (
            b"p = { flow = 20 lpm }\n",
            "my.toml:1: " + wording.files.unquoted_value.format(value="20 lpm"),
        ),
        (b"a = " + b"[" * 20_000, wording.files.is_not_toml),
        (b"a = " + b"9" * 20_000, wording.files.is_not_toml),
        (b"#" * 1_000_001, "1000001 bytes"),
        (b"oil = 3\n", "circuit: " + wording.files.missing),
        (b'circuit = "tests.systems.table_circuit:unit_on_load"\noil = 3\n', wording.files.is_no_table.format(value=3)),
        (b'circuit = "orifice-load"\n', "'orifice-load' " + wording.files.is_no_circuit),
        (b'circuit = ["orifice-load"]\n', wording.files.is_no_circuit),
        (
            b'circuit = "tests.systems.table_circuit:unit_on_load"\nrun = 3\n',
            "run: " + wording.files.is_no_table.format(value=3),
        ),
        (b"\x00\x01", wording.files.is_not_toml),
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
    assert wording.files.too_large in refused("show", "my.toml")[0]


def test_a_unit_that_would_take_hours_to_work_out(refused):
    assert wording.files.unknown_unit in refused("show", "prototype", "--set", "inlet.volume=1 m^9^9^9^9")[0]


def test_places_that_are_no_files(here, refused, monkeypatch):
    assert wording.files.no_system in refused("run", "protoype")[0]
    assert wording.files.no_file in refused("run", "protoype.toml")[0]
    assert wording.files.is_directory in refused("run", str(here))[0]
    assert wording.files.no_system in refused("run", "x" * 5000)[0]
    assert wording.files.cannot_read in refused("run", "x" * 5000 + ".toml")[0]
    assert wording.files.no_system in refused("run", "")[0] or "directory" in refused("run", "")[0]
    assert wording.files.is_no_regular_file in refused("run", "/dev/zero")[0]
    os.mkfifo("pipe.toml")
    assert wording.files.is_no_regular_file in refused("run", "pipe.toml")[0]
    (here / "loop.toml").symlink_to("loop.toml")
    assert wording.files.cannot_read in refused("run", "loop.toml")[0]


def test_a_file_that_may_not_be_read(here, refused, monkeypatch):
    (here / "my.toml").write_text(PROTOTYPE)

    def denied(self):
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr("pathlib.Path.read_bytes", denied)
    assert refused("show", "my.toml") == ["my.toml: " + wording.files.cannot_read + " (Permission denied)"]


@pytest.mark.parametrize(
    ("setting", "said"),
    [
        ("inlet.volume", wording.files.expected_setting),
        ("=3 cc", wording.files.expected_setting),
        ("inlet.volume=", wording.files.no_value),
        ("volume=3 cc", wording.files.expected_setting),
        ("duty_ratio=1.4", "duty_ratio=1.4: " + wording.files.expected_setting),
        ("duty_ratio=1.4", wording.files.did_you_mean.format(name="operation.duty_ratio=1.4")),
        ("a.b.c=3 cc", "--set: a: " + wording.files.unknown_table),
        ("inlet.volum=3 cc", wording.files.did_you_mean.format(name="volume")),
        ("inlets.volume=3 cc", wording.files.unknown_table),
        ("inlet.volume=3 bar", wording.files.is_not_a.format(quantity="a volume")),
        ("inlet.volume={step=", wording.files.is_not_toml),
        ("inlet.volume={step=['1 cc','2 cc'], at='1 s'}", wording.files.does_not_change),
        ("operation.duty_ratio={ramp=['0','1'], from='1 s', to='0 s'}", wording.files.before_it_begins),
        ("operation.duty_ratio={table=[['1 s','0'],['0 s','1']]}", wording.files.backwards),
        ("title.a=3", wording.files.is_no_table.format(value="'title'")),
        ("operation.axial_position=10 km", wording.files.is_outside),
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
    assert wording.files.cannot_write + " (File exists: " in refused(*short, "file/below")[0]
    assert wording.files.cannot_write in refused(*short, "/proc/below")[0]
    assert wording.files.cannot_write in refused(*short, "x" * 300)[0]
    assert wording.files.already_exists in refused(*short, "file")[0]
    assert wording.files.is_no_directory in refused(*short, "file", "--force")[0]
    assert wording.files.already_exists in refused(*short, "full")[0]
    assert wording.files.holds_something_else in refused(*short, "full", "--force")[0]
    assert wording.files.holds_something_else in refused(*short, ".", "--force")[0]
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
        (("report", "nowhere"), wording.files.no_directory),
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
