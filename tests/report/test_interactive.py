"""Packing the data of live charts: what comes out is what went in, within the stated error."""

import base64
import hashlib
import json
import re
import zlib
from dataclasses import replace

import numpy as np
import pytest

from vvdp.base import kinds
from vvdp.report.interactive import (
    BLOCK,
    EXACT_ROWS,
    SCRIPTS,
    VIEWER,
    Columns,
    asset,
    interactive_data,
    is_live,
    live_body,
    live_head,
    pack_column,
)
from vvdp.report.shown import line_looks
from vvdp.results.chart import Bars, Chart, Colour, Line, Lines, Stroke
from vvdp.results.result import Column, Table

RNG = np.random.default_rng(11)


def unpack(description, content):
    """An unpacking apart from the one of the page: sums of differences, by NumPy."""
    count, parts = description["count"], description.get("parts", 0)
    if description["form"] == "exact":
        return np.frombuffer(content, "<f8", count, description["at"])
    if description["form"] == "runs":
        runs = np.frombuffer(content, "<f8", 3 * parts, description["at"]).reshape(-1, 3)
        return np.concatenate([begin + step * np.arange(int(rows)) for begin, step, rows in runs])
    low, step = np.frombuffer(content, "<f8", 2 * parts, description["at"]).reshape(-1, 2).T
    at = description["at"] + 16 * parts
    halves = np.frombuffer(content, np.uint8, 2 * count, at).reshape(2, count).astype(np.int64)
    codes = np.cumsum(halves[0] + 256 * halves[1]) % 65536
    block = np.arange(count) // description["block"]
    return np.where(codes == 65535, np.nan, low[block] + codes * step[block])


def there_and_back(values):
    description, content = pack_column(values)
    return description["form"], unpack({"at": 0, "count": values.size, **description}, content)


def test_short_columns_are_exact():
    values = RNG.normal(size=EXACT_ROWS)
    form, found = there_and_back(values)
    assert form == "exact"
    assert np.array_equal(found, values)


def test_error_of_long_columns_is_a_half_step_of_each_block():
    values = np.cumsum(RNG.normal(size=10 * BLOCK + 17)) * 10.0 ** RNG.integers(-3, 4, 10 * BLOCK + 17)
    form, found = there_and_back(values)
    assert form == "blocks"
    for begin in range(0, values.size, BLOCK):
        block = slice(begin, begin + BLOCK)
        assert np.max(abs(found[block] - values[block])) <= 0.5001 / 16382 * np.ptp(values[block])


def test_what_is_not_finite_is_a_gap():
    values = RNG.normal(size=5 * BLOCK)
    values[[0, 700, 2 * BLOCK]] = np.nan, np.inf, -np.inf
    values[3 * BLOCK : 4 * BLOCK] = np.nan
    found = there_and_back(values)[1]
    assert np.array_equal(np.isnan(found), ~np.isfinite(values))


def test_a_column_that_does_not_change_is_exact():
    assert np.array_equal(there_and_back(np.full(3000, 101325.0))[1], np.full(3000, 101325.0))


def test_even_steps_are_three_numbers_for_each_stretch():
    values = np.concatenate([0.25 + 1e-4 * np.arange(4000), 2.0 + 1e-6 * np.arange(9000)])
    form, found = there_and_back(values)
    assert form == "runs"
    assert len(pack_column(values)[1]) == 3 * 24  # the jump stands alone
    assert np.max(abs(found - values)) < 1e-12


def test_uneven_time_stays_in_order():
    time = np.cumsum(RNG.exponential(size=50_000))
    form, found = there_and_back(time)
    assert form == "blocks"
    assert np.all(np.diff(found) >= 0.0)


def test_a_column_is_packed_once():
    columns, values = Columns(), RNG.normal(size=3000)
    assert columns.place(values) == columns.place(values.copy()) == 0
    assert columns.place(2.0 * values) == 1


@pytest.fixture
def table():
    columns = {
        "time_s": Column(np.linspace(0.0, 2.0, 3001), kinds.TIME, "time"),
        "load_Pa": Column(1e5 * RNG.uniform(50.0, 60.0, 3001), kinds.PRESSURE_LEVEL, "load </script> & more"),
    }
    return Table(title="course", columns=columns)


CHART = Chart(
    name="course", caption="", table="run", panels=(Lines(lines=(Line(x="time_s", y="load_Pa"),), left=1.0, right=1.5),)
)


def test_values_are_packed_as_shown(table):
    page = json.loads(interactive_data([CHART], {"run": table}))
    panel = page["charts"][0]["panels"][0]
    content = zlib.decompress(base64.b64decode(page["bytes"]))
    x, y = (unpack(page["columns"][panel["lines"][0][key]], content) for key in "xy")
    assert panel["x"]["unit"] == "ms"
    assert (panel["x"]["low"], panel["x"]["high"]) == pytest.approx((1000.0, 1500.0))
    assert x == pytest.approx(1e3 * table["time_s"], abs=1e-6)
    assert y == pytest.approx((table["load_Pa"] - 101325.0) / 1e5, abs=3.06e-4)  # bar gauge; 10 / 16382 / 2


def test_long_columns_are_thinned_and_short_ones_kept(table):
    page = json.loads(interactive_data([CHART], {"run": table}, 4))
    panel = page["charts"][0]["panels"][0]
    content = zlib.decompress(base64.b64decode(page["bytes"]))
    x, y = (unpack(page["columns"][panel["lines"][0][key]], content) for key in "xy")
    assert x == pytest.approx(1e3 * table["time_s"][::4], abs=1e-6)
    assert y == pytest.approx((table["load_Pa"][::4] - 101325.0) / 1e5, abs=3.06e-4)
    short = Columns(4)
    assert short.described[short.place(np.arange(512.0))]["count"] == 512


def test_same_bytes_when_made_again(table):
    assert live_body([CHART], {"run": table}) == live_body([CHART], {"run": table})


def test_words_of_a_table_cannot_end_the_script(table):
    body = live_body([CHART], {"run": table})
    assert body.count("</script>") == len(SCRIPTS) + 1


def test_the_policy_allows_every_script_that_a_page_may_have(table):
    scripts = re.findall(r"<script>(.*?)</script>", live_body([CHART], {"run": table}), re.DOTALL)
    for script in (*scripts, asset(VIEWER)):
        digest = base64.b64encode(hashlib.sha256(script.encode()).digest()).decode()
        assert f"'sha256-{digest}'" in live_head()
    assert live_head().count("sha256-") == len(scripts) + 1


def test_bars_stay_still(table):
    bars = replace(CHART, panels=(Bars(names="name", values=("load_Pa",)),))
    assert not is_live(bars)
    assert live_body([bars], {"run": table}) == ""


def test_a_line_takes_the_next_free_colour():
    own = Line(x="x", y="a", colour=Colour.INLET)
    free = [Line(x="x", y=str(place)) for place in range(9)]
    looks = line_looks(Lines(lines=(own, *free)))
    assert looks[0] == (Colour.INLET, Stroke.SOLID)
    assert Colour.INLET not in [colour for colour, _ in looks[1:]]
    assert len(set(looks)) == 10
    assert looks[8] == (Colour.LOAD, Stroke.DASHED)
