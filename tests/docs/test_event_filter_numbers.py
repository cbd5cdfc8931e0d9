"""Numbers that docs/models/event-filter.md spells out about silence, ripple, suspicion and the limits."""

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import quad

from vvdp.estimation import association, between_edges, doubt, event_filter, event_settings, silence
from vvdp.estimation.event_memory import event_filter_start
from vvdp.estimation.silence import Silence, after_silence
from vvdp.numerics.kalman import AngleSpeed, predict
from vvdp.sensing.reading import Reading
from vvdp.sensing.wheel import equal_wheel
from vvdp.simulation.replay import Replay

TEXT = (Path(__file__).parents[2] / "docs" / "models" / "event-filter.md").read_text("utf-8")
PAGE = " ".join(TEXT.split())
USUAL = event_settings.event_filter(equal_wheel(8))
SECTOR, SPEED = np.pi / 4.0, 155.0
BELIEF = AngleSpeed(0.0, SPEED, 2.6e-4, 4e-4, 0.03)


def table(heading):
    """Cells of the table below the line that begins with a heading."""
    rows = TEXT.partition("\n" + heading)[2].partition("\n\n")[0].splitlines()[2:]
    return [[cell.strip() for cell in row.strip("|").split("|")] for row in rows]


def test_what_is_assumed_is_what_the_code_has():
    rows = {name.strip("`"): float(value.split()[0]) for name, value, *_ in table("| | value | meaning")}
    modules = (silence, association)
    known = {name: next(getattr(m, name) for m in modules if hasattr(m, name)) for name in rows if name.isupper()}
    assert rows.pop("stop_rate") == USUAL.stop_rate and rows == known
    assert f"`DECIDED`), at the latest after {doubt.LONGEST:.0f} edges" in PAGE and "$e^{\\pm 4}$" in PAGE
    assert doubt.DECIDED == 4.0 and between_edges.HARDLY == 2.0 and "exceeds 2 (`HARDLY`)" in PAGE
    assert between_edges.SUSPECTED == 6.0 and f"by 1/{event_filter.UNREST:.0f} an edge" in PAGE
    assert f"more than {100 * silence.UNLIKELY:.0f} %" in PAGE


def test_edges_missed_in_a_row():
    chances = [association.missed_in_a_row(1e-3, 64.0, k) for k in (1.0, 2.0, 3.0)]
    assert "1.0e-3, 2.7e-5, 1.4e-6" in PAGE and chances == pytest.approx([1.0e-3, 2.7e-5, 1.4e-6], rel=0.04)
    of_a_stop = 0.01 * SECTOR / SPEED
    assert "5.1 \\cdot 10^{-5}" in PAGE and of_a_stop == pytest.approx(5.1e-5, rel=0.01)


def stands_after(stop_rate, irregular):
    """Sectors, of those that a wheel that stopped at an edge would have turned, until it is rather thought to stand."""
    for sectors in np.arange(1.0, 12.0, 0.05):
        h = sectors * SECTOR / SPEED
        told = Silence(
            duration=h,
            last_edge=0.0,
            next_edge=SECTOR,
            edge_variance=USUAL.edge_variance,
            irregular=irregular,
            watched=64.0,
            stop_rate=stop_rate,
            start_variance=USUAL.speed_variance,
        )
        heard = after_silence(predict(BELIEF, h, 0.25), predict(BELIEF, h, 0.25 + 2e4), told)
        if heard.standstill > 0.5:
            return sectors
    return np.inf


def test_how_soon_a_standstill_is_told():
    rows = table("| `stop_rate` [1/s]")
    assert len(rows) == 5
    for rate, *cells in rows:
        for irregular, cell in zip((0.001, 0.01, 0.05, 0.33), cells, strict=True):
            stated = np.inf if cell == "above 12" else float(cell)
            assert stands_after(float(rate), irregular) == pytest.approx(stated, abs=0.1), (rate, irregular)


def test_how_well_a_ripple_is_known():
    errors = [3.0 * np.sqrt(2.0 * 5.53e-3 / (t * SPEED / SECTOR)) for t in (1.0, 10.0, 60.0)]
    assert "0.0225 after a second, 0.0071 after ten, 0.0029 after a minute, or 3.5, 1.1 and 0.45 rad/s" in PAGE
    assert errors == pytest.approx([0.0225, 0.0071, 0.0029], rel=0.01)
    assert [SPEED * x for x in errors] == pytest.approx([3.5, 1.1, 0.45], rel=0.02)
    assert "0.007 rad/s at 3.5 % and 155 rad/s; one step would leave $r^2$, 0.19 rad/s" in PAGE
    left = [SPEED * 0.035**3, SPEED * 0.035**2]
    assert left == pytest.approx([0.007, 0.19], rel=0.06)


def test_a_suspicion():
    start = event_filter_start(USUAL, 0.0, 0.0, SPEED)
    memory = start._replace(manoeuvre=start.manoeuvre._replace(rise=3.5))
    density = between_edges.suspected_density(memory, 5e-3, USUAL)
    assert "$p = 0.052$, and with it 5.6 rad/s more" in PAGE
    assert density / USUAL.manoeuvre_density == pytest.approx(0.052, rel=0.01)
    assert np.sqrt(density * between_edges.SUSPECTED * 5e-3) == pytest.approx(5.6, rel=0.02)


def test_what_no_filter_can_know():
    """The integral of e^2/sigma^2 from a stop, anywhere in a sector, to the edge that fails to come."""
    rate, least, T = 0.01, 0.19, SECTOR / SPEED
    exact = quad(lambda t: t / T * SPEED**2 / (least**2 + rate * t * SPEED**2), 0.0, T)[0]
    tau = least**2 / (rate * SPEED**2)
    assert exact == pytest.approx((1.0 - tau / T * np.log(1.0 + T / tau)) / rate, rel=1e-9)
    assert "it is 89 s: one jam in 5 s adds 18" in PAGE
    assert exact == pytest.approx(89.0, abs=0.6) and exact / 5.0 == pytest.approx(18.0, abs=0.2)
    assert "is 4.9 rad/s uncertain" in PAGE and np.sqrt(0.2 * T) * SPEED == pytest.approx(4.9, abs=0.05)
    assert "states 0.90 rad/s" in PAGE
    assert np.sqrt(4.0 / 3.0 * rate * 0.5 * T) * SPEED == pytest.approx(0.90, abs=0.005)
    deviation = np.sqrt(BELIEF.angle_variance + USUAL.edge_variance)
    uncovered = 0.5 * T + silence.LATE * deviation / SPEED
    assert "3.3 ms in the mean, and $J$ is 2200 s" in PAGE
    assert uncovered == pytest.approx(3.3e-3, abs=5e-5)
    assert uncovered * SPEED**2 / least**2 == pytest.approx(2200.0, rel=0.01)


def sectors_lost(replay, settings, gap, seed):
    """By how many sectors the angle has moved over a loss of the encoder, of a wheel whose speed walks."""
    rng, step, until = np.random.default_rng([seed, int(1000 * gap)]), 1e-4, 4.0 + gap
    time = np.arange(0.0, until, step)
    speed = 155.2 + np.cumsum(np.sqrt(0.5 * step) * rng.normal(size=time.size))
    angle = 0.7 * rng.random() + np.concatenate([[0.0], np.cumsum(speed[:-1] * step)])
    numbers = np.arange(1, int(angle[-1] / SECTOR) + 1)
    seen = SECTOR * numbers + np.sqrt(USUAL.edge_variance) * rng.normal(size=numbers.size)
    order = np.argsort(seen)
    passed, numbers = np.interp(seen, angle, time)[order], numbers[order]
    tick = (np.arange(1, int(until * 1000)) + rng.random()) * 1e-3
    sample = np.searchsorted(tick, passed)
    kept = ((passed < 2.0) | (passed > 2.0 + gap)) & (sample < tick.size)
    rows = np.zeros((tick.size, 5))
    rows[:, 0] = tick
    np.add.at(rows[:, 1], sample[kept], 1.0)
    rows[sample[kept], 2:4] = np.column_stack([tick[sample[kept]] - 5e-4, np.full(kept.sum(), 1e-3)])
    rows[sample[kept], 4] = 1.0 - 2.0 * (numbers[kept] % 2.0)
    shown = replay(event_filter_start(settings, 0.0, 0.0, SPEED), rows, settings).shown
    error = shown[:, 0] - np.interp(tick, time, angle)
    before, after = np.median(error[(tick > 1.0) & (tick < 2.0)]), np.median(error[tick > 3.0 + gap])
    return round((after - before) / SECTOR)


@pytest.mark.slow
def test_sectors_lost_with_the_encoder():
    memory = event_filter_start(USUAL, 0.0, 0.0, SPEED)
    replay = Replay(event_filter.event_filter_step, memory, Reading(0.0, 0.0, 0.0, 0.0, 0.0), USUAL)
    (_, *deaf), (_, *hearing) = table("| loss [s] |")
    gaps = [float(x) for x in re.findall(r"[\d.]+", TEXT.partition("| loss [s] |")[2].partition("\n")[0])]
    for settings, cells in ((replace(USUAL, stop_rate=0.0), deaf), (USUAL, hearing)):
        lost = [sum(sectors_lost(replay, settings, gap, seed) != 0 for seed in range(200)) for gap in gaps]
        print(lost)
        assert lost == pytest.approx([int(cell) for cell in cells], abs=2)


def test_what_single_precision_resolves():
    """The angle after an hour at 25 revolutions per second, and a second of 1000 periods, plain and compensated."""
    page = (Path(__file__).parents[2] / "docs" / "models" / "event-filter.md").read_text("utf-8")
    angle = 3600.0 * 25.0 * 2.0 * np.pi
    assert f"{angle:,.0f} rad".replace(",", " ") in page
    assert f"neighbouring floats are {np.spacing(np.float32(angle))} rad apart" in page
    period, plain, since, lost = np.float32(1e-3), np.float32(0.0), np.float32(0.0), np.float32(0.0)
    for _ in range(1000):
        plain = plain + period
        added = period - lost
        total = since + added
        lost, since = (total - since) - added, total
    assert f"add up to {float(plain):.6f} s" in page
    assert since == 1.0
