"""Tables of values with origin: signals, settings, and all faults at once with their lines."""

from pathlib import Path

import pytest
from tests.words import wording

from vvdp.base.errors import ConfigError, Fault, ParameterError
from vvdp.base.kinds import FractionSignal, Length, PressureSignal, Ratio, SpeedSignal, TemperatureSignal
from vvdp.base.params import Params
from vvdp.base.rules import require_less
from vvdp.base.signal import Signal, signal_value
from vvdp.base.tables import Sourced, Table, build, describe_signal, parsed_table, read_table, with_settings


class Plate(Params):
    """Something with two values that depend on each other."""

    length: Length
    ratio: Ratio

    def check(self) -> None:
        if self.ratio > 10.0:
            raise ParameterError(f"ratio {self.ratio:g} is more than 10")


class Prescribed(Params):
    """Something with one signal of each awkward kind."""

    pressure: PressureSignal
    temperature: TemperatureSignal
    speed: SpeedSignal
    share: FractionSignal


CONSTANT = {"pressure": "10 bar", "temperature": "40 degC", "speed": "1800 rpm", "share": "0.5"}


def signal(key: str, entry: object) -> Signal:
    """The signal that `entry` makes under one key of `Prescribed`."""
    faults: list[Fault] = []
    values, _ = build(Prescribed, {**CONSTANT, key: entry}, "p", parsed_table("[p]\n", "p.toml"), faults)
    if faults:
        raise ConfigError(faults)
    found: Signal = getattr(values, key)
    return found


def test_values_come_with_their_origin() -> None:
    table = parsed_table(
        '[plate]\nlength = { value = "5 mm", status = "published", source = "wang2017", where = "p. 3" }\nratio = 2\n',
        "a",
    )
    faults: list[Fault] = []
    plate, rows = build(Plate, table.content["plate"], "plate", table, faults)
    assert not faults and plate == Plate(length=0.005, ratio=2.0)
    first, second = rows
    assert (first.status, first.source, first.where, first.display_text) == ("published", "wang2017", "p. 3", "5 mm")
    assert (second.status, second.source, second.display_text) == ("given", "", "2")


def test_all_faults_are_told_at_once_each_with_its_line() -> None:
    text = """[plate]
lenght = "5 mm"
ratio = { value = "2", status = "guessed" }
"quoted key" = 1

[p]
pressure = "10 bara"
temperature = 40
speed = { step = ["22.5 Hz", "30 rev/s"], at = "1 s" }
share = { value = "0.5", until = "1 s" }
"""
    table = parsed_table(text, "bad.toml")
    faults: list[Fault] = []
    assert build(Plate, table.content["plate"], "plate", table, faults)[0] is None
    assert build(Prescribed, table.content["p"], "p", table, faults)[0] is None
    assert [(f.line, f.key) for f in faults] == [
        (2, "plate.lenght"),
        (3, "plate.ratio"),
        (4, "plate.quoted key"),
        (1, "plate.length"),
        (8, "p.temperature"),
        (9, "p.speed"),
        (10, "p.share"),
    ]
    text = str(ConfigError(faults))
    assert "bad.toml:2: plate.lenght: " + wording.files.unknown_key.format(meant="length") in text
    no_speed = wording.files.is_not_a.format(quantity="a rotational speed")
    write = wording.files.write_instead.format(value="1350 rpm or 22.5 rev/s")
    assert f"bad.toml:9: p.speed: '22.5 Hz' {no_speed}; {write}" in text
    assert wording.files.expected_one_of.format(choices="measured, published, derived, assumed, given") in text


def test_contradictions_are_faults_of_their_table() -> None:
    table = parsed_table('\n[plate]\nlength = "5 mm"\nratio = 11\n', "a")
    faults: list[Fault] = []
    assert build(Plate, table.content["plate"], "plate", table, faults)[0] is None
    assert [str(fault) for fault in faults] == ["a:2: plate: ratio 11 is more than 10"]


@pytest.mark.parametrize(
    ("key", "entry", "base", "amplitude"),
    [
        ("pressure", {"sine": "50 bar", "amplitude": "5 bar", "frequency": "10 Hz"}, 51.01325e5, 5e5),
        ("pressure", {"sine": "50 bara", "amplitude": "5 bara", "frequency": "10 Hz"}, 50e5, 5e5),
        ("pressure", {"sine": "50 bar", "amplitude": "-500 kPa", "frequency": "10 Hz"}, 51.01325e5, -5e5),
        ("temperature", {"sine": "40 degC", "amplitude": "5 K", "frequency": "1 Hz"}, 313.15, 5.0),
        ("temperature", {"sine": "40 degC", "amplitude": "5 degC", "frequency": "1 Hz"}, 313.15, 5.0),
        ("temperature", {"sine": "104 degF", "amplitude": "9 degF", "frequency": "1 Hz"}, 313.15, 5.0),
        ("share", {"sine": "0.5", "amplitude": "10 %", "frequency": "1 Hz", "phase": "90 deg"}, 0.5, 0.1),
        ("share", {"sine": 0.5, "amplitude": 0.1, "frequency": "1 Hz"}, 0.5, 0.1),
    ],
)
def test_an_amplitude_is_a_difference(key: str, entry: object, base: float, amplitude: float) -> None:
    found = signal(key, entry)
    assert found.base == pytest.approx(base, rel=1e-14)
    assert found.amplitude == pytest.approx((amplitude,), rel=1e-13)


def test_the_forms_of_a_signal() -> None:
    assert signal_value(0.0, signal("pressure", "10 bar")) == 1101325.0
    step = signal("pressure", {"step": ["10 bar", "20 bar"], "at": "500 ms"})
    assert [signal_value(t, step) for t in (0.499, 0.5)] == [1101325.0, 2101325.0]
    ramp = signal("share", {"ramp": ["0.2", "0.4"], "from": "1 s", "to": "2 s", "status": "assumed"})
    assert signal_value(1.5, ramp) == pytest.approx(0.3)
    table = signal("share", {"table": [["0 s", "0.2"], ["1 s", "0.4"], ["1 s", "0.6"]]})
    assert [signal_value(t, table) for t in (0.5, 1.0, 2.0)] == pytest.approx([0.3, 0.6, 0.6])


@pytest.mark.parametrize(
    ("entry", "told"),
    [
        ({"step": ["1 bar", "2 bar"]}, wording.files.given_expected.format(keys="step")),
        ({"step": ["1 bar"], "at": "1 s"}, wording.files.given_expected.format(keys="step, at")),
        ({"step": ["1 bar", "2 bar"], "at": "1 s", "to": "2 s"}, "expected"),
        ({"ramp": ["1 bar", "2 bar"], "from": "2 s", "to": "1 s"}, wording.files.before_it_begins),
        ({"table": [["1 s", "1 bar"], ["0 s", "2 bar"]]}, "backwards"),
        ({"table": []}, wording.files.given_expected.format(keys="table")),
        ({"table": [["1 s", "1 bar", "2 bar"]]}, "expected"),
        ({"sine": "50 bar", "amplitude": "5", "frequency": "10 Hz"}, wording.files.has_no_unit),
        (
            {"sine": "50 bar", "amplitude": "5 bar", "frequency": "600 rpm"},
            wording.files.is_not_a.format(quantity="a frequency"),
        ),
        (
            {"sine": "1 bar", "amplitude": "5 bar", "frequency": "1 Hz"},
            "is outside -1.01325 bar (0 bara)",
        ),
        (
            {"table": [["0 s", "1 bar"], ["1 s", "20000 bar"], ["1 s", "1 bar"]]},
            wording.files.outside_from.format(low="-1.01325"),
        ),
        ({}, wording.files.nothing_given),
        ([1, 2], wording.files.is_not_a.format(quantity="a pressure level")),
    ],
)
def test_what_is_no_signal_is_refused(entry: object, told: str) -> None:
    with pytest.raises(ConfigError) as caught:
        signal("pressure", entry)
    assert told in str(caught.value)


def test_a_signal_is_described_as_a_person_reads_it() -> None:
    kind = Prescribed.__annotations__["pressure"].__metadata__[0]
    assert describe_signal(signal("pressure", "10 bar"), kind) == "10 bar (11.0132 bara)"
    text = describe_signal(signal("pressure", {"step": ["10 bar", "20 bar"], "at": "0.5 s"}), kind)
    assert text == wording.files.corners.format(
        low="10 bar (11.0132 bara)", high="20 bar (21.0132 bara)", corners="0.5 s"
    )
    text = describe_signal(signal("pressure", {"sine": "100 bar", "amplitude": "5 bar", "frequency": "7 Hz"}), kind)
    assert text.endswith(wording.files.sine_of.format(frequency="7 Hz"))


def test_settings_replace_values() -> None:
    table = parsed_table('[p]\nspeed = "1 rpm"\n', "a")
    changed = with_settings(table, ["p.speed = 1200 rpm", 'p.pressure={step=["1 bar","2 bar"],at="1 s"}', 'q.x="3 mm"'])
    assert changed.content == {
        "p": {"speed": "1200 rpm", "pressure": {"step": ["1 bar", "2 bar"], "at": "1 s"}},
        "q": {"x": "3 mm"},
    }
    assert table.content == {"p": {"speed": "1 rpm"}}
    with pytest.raises(ConfigError) as caught:
        with_settings(table, ["speed=1 rpm", "p.speed", "p.speed=", "p.speed={step=", "p.speed.b=1"])
    assert len(caught.value.faults) == 5


def test_files_that_cannot_be_read_are_told_apart(tmp_path: Path) -> None:
    (tmp_path / "latin.toml").write_bytes(b'title = "\xe4"')
    (tmp_path / "broken.toml").write_text("[p]\nspeed = \n")
    (tmp_path / "empty.toml").write_text("# nothing\n")
    (tmp_path / "large.toml").write_text("#" * 1_000_001)
    for name, told in (
        ("none.toml", wording.files.no_file),
        (".", wording.files.is_directory),
        ("latin.toml", "not UTF-8"),
        ("broken.toml", "broken.toml:2: " + wording.files.is_not_toml),
        ("empty.toml", wording.files.is_empty),
        ("large.toml", "1000001 bytes"),
    ):
        with pytest.raises(ConfigError) as caught:
            read_table(tmp_path / name)
        assert told in str(caught.value), name


def test_a_signal_that_leaves_its_range_is_a_fault_of_its_own_line_or_option() -> None:
    text = '[operation]\nfirst = "5 mm"\nshare = {sine = "0.5", amplitude = "5", frequency = "1 Hz"}\n'
    faults = refused_signals(parsed_table(text, "a"))
    assert faults == [
        "a:3: operation.share: "
        + wording.files.outside_range.format(value="between -4.5 and 5.5, sine of 1 Hz", low=0, high="1 for a fraction")
    ]
    table = with_settings(parsed_table('[operation]\nfirst = "5 mm"\n', "a"), [f"operation.{text.splitlines()[2]}"])
    assert refused_signals(table) == [
        "--set: operation.share: "
        + wording.files.outside_range.format(value="between -4.5 and 5.5, sine of 1 Hz", low=0, high="1 for a fraction")
    ]


def refused_signals(table: Table) -> list[str]:
    faults: list[Fault] = []
    assert build(Shared, table.content["operation"], "operation", table, faults)[0] is None
    return [str(fault) for fault in faults]


class Shared(Params):
    """A length and a share over time."""

    first: Length
    share: FractionSignal


def ranged(entry: str) -> tuple[list[Sourced], list[Fault]]:
    table = parsed_table(f"[plate]\nratio = 2\nlength = {entry}\n", "plate.toml")
    faults: list[Fault] = []
    return build(Plate, table.content["plate"], "plate", table, faults)[1], faults


def test_a_range_stands_beside_a_value() -> None:
    rows, faults = ranged('{ value = "5 mm", range = ["4 mm", "0.7 cm"], note = "by the drawing" }')
    assert not faults
    (length,) = (row for row in rows if row.key == "length")
    assert length.range == pytest.approx((0.004, 0.007))
    assert (length.nominal, length.setting) == (0.005, "plate.length")
    assert length.remark == "4 mm to 7 mm; by the drawing"
    assert next(row for row in rows if row.key == "ratio").range is None


@pytest.mark.parametrize(
    ("entry", "told"),
    [
        (
            '{ value = "5 mm", range = ["6 mm", "7 mm"] }',
            wording.files.expected_range_of.format(value="5 mm", low="6 mm", high="7 mm"),
        ),
        (
            '{ value = "5 mm", range = ["7 mm", "4 mm"] }',
            wording.files.two_different_ends,
        ),
        ('{ value = "5 mm", range = "4 mm to 6 mm" }', wording.files.as_range.format(value="4 mm to 6 mm")),
        ('{ value = "5 mm", range = ["4 bar", "6 bar"] }', "4 bar"),
        ('{ value = "5 mm", range = ["-1 mm", "6 mm"] }', "-"),
    ],
)
def test_a_range_that_does_not_hold_its_value_is_refused_with_its_line(entry: str, told: str) -> None:
    _, faults = ranged(entry)
    assert [(fault.place, fault.line, fault.key) for fault in faults] == [("plate.toml", 3, "plate.length")]
    assert told in faults[0].message


def test_what_changes_over_time_has_no_range() -> None:
    entry = {"step": ["0.2", "0.4"], "at": "1 s", "range": ["0.1", "0.5"]}
    with pytest.raises(ConfigError, match=wording.files.value_that_changes):
        signal("share", entry)
    assert signal("share", {"value": "0.3", "range": ["0.1", "0.5"]}).base == 0.3


class Span(Params):
    lower: Length
    upper: Length

    def check(self) -> None:
        require_less(self, "lower", "upper")


@pytest.mark.parametrize(
    ("lower", "message"),
    [
        ("20 mm", "20 mm must be less than upper, 10 mm"),
        ("1 inch", "'1 inch' = 25.4 mm must be less than upper, 10 mm"),
    ],
)
def test_a_value_is_refused_in_the_unit_of_the_file(lower, message):
    faults = []
    given = {"lower": {"value": lower, "status": "assumed"}, "upper": "10 mm"}
    build(Span, given, "span", Table("a", {}, {}), faults)
    assert [str(fault) for fault in faults] == [f"a: span.lower: {message}"]
