"""Tables in text: every way of writing the same numbers is read as the same numbers, or refused with its line."""

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from tests.words import wording

from vvdp.base.errors import ConfigError
from vvdp.logs import text as module
from vvdp.logs.source import open_log


def opened(path, content, **options):
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    return open_log(path, **options)


def column(log, name, samples=7):
    parts = [part[name] for part in log.portions([name], samples)]
    return np.concatenate([p.times for p in parts]), np.concatenate([p.values for p in parts])


numbers = st.one_of(
    st.floats(allow_nan=False, allow_infinity=True),
    st.integers(-(10**9), 10**9).map(float),
    st.just(float("nan")),
)


@st.composite
def dialects(draw):
    delimiter = draw(st.sampled_from(["\t", ";", "|", ",", " ", ", "]))
    decimal = "." if delimiter.startswith(",") else draw(st.sampled_from(".,"))
    blank = delimiter == " "
    missing = draw(
        st.sampled_from(["nan", "NaN", "NA"] if blank else ["nan", "", "N/A", "-1.#IND".replace(".", decimal)])
    )
    return {
        "delimiter": delimiter,
        "decimal": decimal,
        "missing": missing,
        "end": draw(st.sampled_from(["\n", "\r\n"])),
        "bom": draw(st.booleans()),
        "comments": draw(st.booleans()),
        "quoted": draw(st.booleans()) and not blank,
        "units": draw(st.sampled_from(["[]", "()", "row", "none"]))
        if not blank
        else draw(st.sampled_from(["row", "none"])),
        "last": draw(st.booleans()),
    }


def written(rows, how):
    """The text of a table of rows."""

    def number(value):
        text = how["missing"] if np.isnan(value) else repr(value).replace(".", how["decimal"])
        return f'"{text}"' if how["quoted"] and how["decimal"] == "," else text

    names, units = ["time", "alpha", "beta"], ["s", "bar", "V"]
    if how["units"] in ("[]", "()"):
        left, right = how["units"]
        names = [f"{name} {left}{unit}{right}" for name, unit in zip(names, units, strict=True)]
    if how["quoted"]:
        names = [f'"{name}"' for name in names]
    lines = ["# written by a test"] if how["comments"] else []
    lines.append(how["delimiter"].join(names))
    if how["units"] == "row":
        lines.append(how["delimiter"].join(units))
    for k, row in enumerate(rows):
        lines.append(how["delimiter"].join(map(number, row)))
        if how["comments"] and k % 3 == 0:
            lines += ["# in between", ""]
    text = how["end"].join(lines) + (how["end"] if how["last"] else "")
    return (b"\xef\xbb\xbf" if how["bom"] else b"") + text.encode()


@given(
    how=dialects(), values=st.lists(st.tuples(numbers, numbers), min_size=2, max_size=30), samples=st.integers(1, 40)
)
@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], max_examples=150)
def test_every_dialect_is_read_to_the_last_bit(tmp_path_factory, how, values, samples):
    rows = [(0.1 * k + 0.05, *pair) for k, pair in enumerate(values)]
    path = tmp_path_factory.mktemp("dialect") / "a.csv"
    log = opened(path, written(rows, how))
    for k, name in ((1, "alpha"), (2, "beta")):
        times, found = column(log, name, samples)
        assert np.array_equal(times, [row[0] for row in rows])
        assert np.array_equal(found, [row[k] for row in rows], equal_nan=True)
    assert log.channel("alpha").unit == ("" if how["units"] == "none" else "bar")


def test_what_instruments_write_in_place_of_a_value_is_no_number(tmp_path):
    words = ["OVER", "Overload", "--", "#N/A", "Error", "invalid"]
    rows = [(k, words[k // 10] if k % 10 == 5 and k < 60 else str(k)) for k in range(100)]
    log = opened(tmp_path / "a.csv", "t [s],v\n" + "".join(f"{t},{v}\n" for t, v in rows))
    values = column(log, "v")[1]
    assert np.flatnonzero(np.isnan(values)).tolist() == [5, 15, 25, 35, 45, 55]


def test_small_blocks_of_lines_make_no_difference(tmp_path):
    """Blocks end anywhere: the same numbers, whatever the size of a portion (blocks have at least 4096 bytes)."""
    rows = [(k * 1e-3, float(k % 7) if k % 5 else np.nan) for k in range(3000)]
    lines = ["t [ms];v", *(f"{t!r};{'' if np.isnan(v) else repr(v)}".replace(".", ",") for t, v in rows)]
    log = opened(tmp_path / "a.csv", "\n".join(lines))
    for samples in (1, 300, 10_000):
        times, values = column(log, "v", samples)
        assert np.array_equal(times, [t / 1e3 for t, _ in rows])
        assert np.array_equal(values, [v for _, v in rows], equal_nan=True)


def test_the_careful_and_the_fast_parser_agree(tmp_path, monkeypatch):
    random = np.random.default_rng(1)
    values = random.normal(size=500) * 10.0 ** random.integers(-300, 300, 500)
    text = "t,v\n" + "".join(f"{k},{v!r}\n" for k, v in enumerate(values.tolist()))
    fast = column(opened(tmp_path / "a.csv", text), "v")[1]
    monkeypatch.setattr(module._Table, "_plain", lambda self, block: None)
    assert np.array_equal(column(opened(tmp_path / "a.csv", text), "v")[1], fast)
    assert np.array_equal(fast, values)


@pytest.mark.parametrize(("unit", "seconds"), [
    ("s", [0.0, 5.0]), ("ms", [0.0, 0.005]), ("us", [0.0, 5 / 1e6]), ("µs", [0.0, 5 / 1e6]), ("ns", [0.0, 5 / 1e9]),
    ("min", [0.0, 300.0]), ("h", [0.0, 18000.0]),
])  # fmt: skip
def test_time_units_become_seconds(tmp_path, unit, seconds):
    for text in (f"t [{unit}],v\n0,1\n5,2\n", f"Time ({unit}),v\n0,1\n5,2\n", f"time,v\n{unit},V\n0,1\n5,2\n"):
        for coded in (text.encode(), text.encode("latin-1")):
            assert np.array_equal(column(opened(tmp_path / "a.csv", coded), "v")[0], seconds)


def test_a_time_without_unit_is_taken_as_seconds_and_said(tmp_path):
    log = opened(tmp_path / "a.csv", "time,v\n0,1\n5,2\n")
    assert np.array_equal(column(log, "v")[0], [0.0, 5.0])
    assert log.remarks == (wording.logs.taken_as.format(channel="time", unit="s"),)
    log = opened(tmp_path / "a.csv", "time,v\n0,1\n5,2\n", time_unit="ms")
    assert np.array_equal(column(log, "v")[0], [0.0, 0.005]) and not log.remarks
    assert np.array_equal(column(opened(tmp_path / "a.csv", "t_ms,v\n0,1\n5,2\n"), "v")[0], [0.0, 0.005])


def test_another_column_may_be_the_clock(tmp_path):
    log = opened(tmp_path / "a.csv", "x [s],t,v\n1,0,1\n2,5,2\n", time="x")
    assert np.array_equal(column(log, "v")[0], [1.0, 2.0])


STAMPS = ["2024-02-29T23:59:59.9995", "2024-03-01T00:00:00.0005"]


@pytest.mark.parametrize("write", [
    str, lambda s: s.replace("T", " "), lambda s: s + "Z", lambda s: s + "+02:00", lambda s: s[:23],
    lambda s: s.replace(".", ","),
    lambda s: s + "00001" if s == STAMPS[0] else s,
])  # fmt: skip
def test_date_times_become_seconds_from_the_first(tmp_path, write):
    lines = [f"{write(stamp)};{k}" for k, stamp in enumerate(STAMPS)]
    times, _ = column(opened(tmp_path / "a.csv", "\n".join(["Zeitstempel;v", *lines]) + "\n"), "v")
    # Across a leap day: 1 ms, less the nanosecond that the longer fraction adds to the first.
    longer = "00001" in lines[0]
    assert times[0] == 0.0
    assert times[1] == pytest.approx(1 / 1e3 - 1 / 1e9 * longer, abs=1e-12)


def test_date_times_are_read_to_the_nanosecond_with_any_offset():
    random = np.random.default_rng(2)
    stamps = np.sort(np.datetime64("1999-12-31T00:00:00", "ns") + random.integers(0, 10**15, 200).astype("m8[ns]"))
    texts = [str(stamp) for stamp in stamps]
    assert np.array_equal(module._instants(texts), stamps)
    shifted = [t[:19] + "+01:30" for t in texts]
    expected = stamps.astype("M8[s]") - np.timedelta64(90, "m")
    assert np.array_equal(module._instants(shifted), expected.astype("M8[ns]"))
    assert np.array_equal(module._instants([shifted[0], shifted[1][:19] + "Z"])[0], expected[0])
    assert module._instants([shifted[0], texts[1]]) is None  # with an offset and without


def test_impossible_date_times_are_refused(tmp_path):
    for bad in ("2024-02-30T00:00:00", "2024-01-01T24:30:00", "yesterday"):
        log = opened(tmp_path / "a.csv", f"time,v\n2024-01-01T00:00:00,0\n2024-01-01T00:00:01,1\n{bad},2\n")
        with pytest.raises(ConfigError, match="a.csv:4: time: " + wording.logs.no_date.format(value=bad)):
            column(log, "v")


def test_preamble_text_columns_and_names(tmp_path):
    text = "Recorded by NN\nOn the bench\n\nt;p [bar];p [bar];state;\ns;;;;\n0;1;2;ok;\n1;3;4;ok;\n"
    log = opened(tmp_path / "a.csv", text)
    assert [info.name for info in log.channels()] == ["t", "p", "p #2"]
    assert np.array_equal(column(log, "p #2")[1], [2.0, 4.0])
    assert log.unreadable == {"state": wording.logs.holds_text, "column 5": wording.files.is_empty}
    assert any(wording.logs.not_part_of_table.format(first=1, last=2) in remark for remark in log.remarks)
    with pytest.raises(ConfigError, match=wording.logs.expected_numbers.format(channel="state")):
        log.channel("state")


def test_parentheses_that_hold_no_unit_belong_to_the_name(tmp_path):
    log = opened(tmp_path / "a.csv", "t (s),pressure (left),flow (l/min),level[2]\n0,1,2,3\n")
    assert [(info.name, info.unit) for info in log.channels()] == [
        ("t", "s"), ("pressure (left)", ""), ("flow", "l/min"), ("level[2]", "")
    ]  # fmt: skip


@pytest.mark.parametrize("text", ["edge [s]\n0.5\n1.5\n", "edge\n0,5\n1,5\n", "the edge\ns\n0.5\n1.5\n"])
def test_a_table_of_one_column(tmp_path, text):
    log = opened(tmp_path / "a.csv", text, rate=1.0)
    (info,) = log.channels()
    assert np.array_equal(column(log, info.name)[1], [0.5, 1.5])


def test_a_file_without_names(tmp_path):
    log = opened(tmp_path / "a.csv", "0 1\n1 2\n2 3\n", time="column 1")
    assert np.array_equal(column(log, "column 2")[1], [1.0, 2.0, 3.0])
    assert wording.logs.no_names in log.remarks


def test_the_separator_of_a_spreadsheet(tmp_path):
    assert np.array_equal(column(opened(tmp_path / "a.csv", "sep=|\nt|v\n0|1,5\n1|2,5\n"), "v")[1], [1.5, 2.5])


def test_a_last_line_that_breaks_off_is_left_out_and_said(tmp_path):
    log = opened(tmp_path / "a.csv", "t,u,v\n0,1,2\n1,2,3\n2,3")
    assert np.array_equal(column(log, "v")[1], [2.0, 3.0])
    assert any(wording.logs.breaks_off.format(line=4) in remark for remark in log.remarks)


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("t,v\n0,1\n1,2\n2,x\n", "a.csv:4: v: " + wording.logs.not_a_number.format(value="x")),
        ("t,v\n0,1\n1,x\n2,3\n3,4\n", "a.csv:3: " + wording.logs.neither.format(line="1, x")),
        ("t,v\n0,1\n1,2\n2,3,4\n", "a.csv:4: " + wording.logs.fields.format(found=3, expected=2)),
        ("t,v\n0,1\n1,2\n2\n3,4\n", "a.csv:4: " + wording.logs.fields.format(found=1, expected=2)),
        (
            "t;v\n0;1,5\n1;2,5\n2;3.5\n",
            "a.csv:4: v: " + wording.logs.decimal_sign.format(value=3.5, sign=".", expected=","),
        ),
        ("t;v\n0;1,5\n1;1.002,5\n2;1,5\n", "a.csv:3: " + wording.logs.neither.format(line="1; 1.002,5")),
        ("t;v\n0;1,5\n1;2,5\n2;1.002,5\n", "a.csv:4: v: " + wording.logs.not_a_number.format(value="1.002,5")),
        ("t,v,w\n0,1\n1,2\n", "a.csv:1: " + wording.logs.names.format(found=3, expected=2)),
        ("nothing\nbut words\n", wording.logs.no_row),
        ("t,v\r0,1\r1,2\r", wording.logs.cr_alone),
        ("t,v\n0,1\n1,1_000\n", "a.csv:2: " + wording.logs.neither.format(line="0, 1")),
        ("t,v\n0,1\n1,0\n2,1_0\n", "a.csv:4: v: " + wording.logs.not_a_number.format(value="1_0")),
    ],
)
def test_a_fault_is_named_with_its_line(tmp_path, text, expected):
    with pytest.raises(ConfigError) as caught:
        column(opened(tmp_path / "a.csv", text), "v")
    assert expected.replace("; 1.002,5", ", 1.002,5") in str(caught.value)


def test_a_fault_far_down_is_named_with_its_line(tmp_path):
    lines = ["t,v", *(f"{k},{k}" for k in range(20_000))]
    lines[15_432] = "15431,oops"
    log = opened(tmp_path / "a.csv", "\n".join(lines) + "\n")
    read = 0
    with pytest.raises(ConfigError, match="a.csv:15433: v: " + wording.logs.not_a_number.format(value="oops")):
        for part in log.portions(["v"], 1000):
            read += part["v"].values.size
    assert 14_000 < read < 15_432  # what came before was given
