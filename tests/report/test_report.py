"""The report is whole, stands alone, says what is wrong, and is the same each time."""

import html.parser
import json
import re
import shutil
import xml.etree.ElementTree as ET

import numpy as np
import pytest
from tests.words import wording

from vvdp.base.errors import ConfigError
from vvdp.base.files import list_all, write_listed
from vvdp.base.kinds import SPEED
from vvdp.base.manifest import open_directory
from vvdp.evaluation.bench_overview import OVERVIEW_NOTE
from vvdp.evaluation.overview import warnings
from vvdp.evaluation.quantities import quantities
from vvdp.report.report import write_report
from vvdp.report.result_page import Page, listing_html, write_result_page
from vvdp.results.result import Badge, Finding, Grade, Listing, Result, Row
from vvdp.runs.bench import causes, components
from vvdp.runs.lead import lead
from vvdp.runs.result import key_listings, run_result
from vvdp.runs.run import open_run
from vvdp.runs.simulate import run_system
from vvdp.systems.system import load_system
from vvdp.valve.validity import CAVITATION_NUMBER

FIGURES = {"cycle-time", "cycle-angle", "run", "speed", "spectrum", "losses-cause", "losses-component"}
VOID = {"meta", "br", "wbr", "img", "hr", "input", "link"}


class Balanced(html.parser.HTMLParser):
    """Fails on an element that is closed out of turn; collects what a page would load, and identifiers."""

    def __init__(self):
        super().__init__()
        self.open, self.loaded, self.names, self.targets = [], [], [], []

    def handle_starttag(self, tag, attrs):
        given = dict(attrs)
        self.names += [given["id"]] if "id" in given else []
        self.targets += [v[1:] for k, v in attrs if k in ("href", "xlink:href") and v.startswith("#")]
        self.loaded += [v for k, v in attrs if k in ("src", "href", "xlink:href", "data") and not v.startswith("#")]
        self.loaded += [tag] if tag in ("iframe", "link", "img") else []
        if tag not in VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag, attrs):
        self.handle_starttag(tag, attrs)
        if tag not in VOID:
            self.open.pop()

    def handle_endtag(self, tag):
        assert self.open.pop() == tag


def page(directory):
    path = write_report(directory)
    assert path == directory / "report.html"
    return path.read_text("utf-8")


def words(text):
    return re.sub(r"<[^>]*>", "", text.partition("<body>")[2])


def edit(path, **changes):
    path.write_text(json.dumps(json.loads(path.read_text()) | changes))
    list_all(path.parent)


@pytest.fixture(scope="module")
def reported(whole, tmp_path_factory):
    """The directory of the session's run with its report, to be read."""
    directory = shutil.copytree(whole, tmp_path_factory.mktemp("written") / "run")
    page(directory)
    return directory


@pytest.fixture(scope="module")
def written(reported):
    """The page of the session's run."""
    return (reported / "report.html").read_text("utf-8")


def test_the_page_stands_alone_and_is_well_formed(written):
    text = written
    seen = Balanced()
    seen.feed(text)
    assert "default-src 'none'" in text
    assert not seen.open
    assert seen.loaded == []
    assert len(seen.names) == len(set(seen.names))
    assert set(seen.targets) <= set(seen.names)
    assert not re.search(r"url\((?!#)|@import|(src|href)=.https?:", re.sub(r"(?s)<script.*?</script>", "", text))


def test_every_figure_is_there(reported, written):
    for name in FIGURES:
        ET.parse(reported / "figures" / f"{name}.svg")
        assert f'id="figure-{name}"' in written
    ET.parse(reported / "figures" / "circuit.svg")
    assert not list(reported.rglob("*.tmp"))


def content(directory):
    return {p.name: p.read_bytes() for p in directory.rglob("*") if p.is_file()}


def test_made_again_it_has_the_same_bytes(reported, tmp_path):
    again = shutil.copytree(reported, tmp_path / "run")
    write_report(again)
    assert content(again) == content(reported)


def test_it_lists_what_is_assumed_and_where_values_come_from(written):
    text = written
    system = load_system("prototype")
    assert wording.report.assumed.format(assumed=len(system.assumptions), values=len(system.rows)) in text
    listed = text.partition('id="assumed-values"')[2].partition('id="parameters"')[0].replace("<wbr>", "")
    for row in system.assumptions:
        assert f"{row.table}.{row.key}" in listed
    assert "Meng Wang" in text and "Herbert E. Merritt" in text
    assert "Tsitouras" not in text


def test_numbers_are_in_the_units_people_use(whole, written):
    found = json.loads((whole / "summary.json").read_text())
    said = words(written)
    assert f"{found['mean_load_flow_m3_s'] * 6e4:.2f} lpm" in said
    assert wording.report.pressure_of.format(pressure=f"{found['pressure_mean_load_line_Pa'] / 1e5:.4g} bar") in said
    assert f"{found['efficiency'] * 100:.2f} %" in said
    assert "prototype" in said and "2026-01-02" in said
    assert "vvdp run prototype" in said


def test_losses_by_cause_and_by_component_are_all_that_is_lost(whole):
    """An ideal pump has no loss of its chambers; its leakage counts all the same."""
    run = open_run(whole)
    assert "loss_pump_compression_W" not in run.summary and run.number("loss_pump_leakage_W") > 100.0
    rest = run.number("loss_total_W") - run.number("stored_power_W")
    for listed in (causes(run), components(run)):
        assert sum(loss.simulated for loss in listed) == pytest.approx(rest, rel=1e-5)


def test_lines_of_the_overview_are_all_that_is_lost(whole):
    rows = {row.label: row.values for row in key_listings(open_run(whole))["overview"].rows}
    for column in (0, 1):
        parts = [values[column] for label, values in rows.items() if label.startswith("loss, ")]
        total = rows[wording.report.input_less_load][column]
        assert sum(part for part in parts if part is not None) == pytest.approx(total, rel=1e-3)


def test_words_stand_behind_the_unit(whole):
    rows = (Row("speed", SPEED, (100.0, 120.0, "lap")), Row("speed", SPEED, (90.0, None, "lag")))
    listing = Listing(title="", heads=("lowest", "highest", "mostly by"), rows=rows)
    assert listing.unit_place == 2
    text = words("<body>" + listing_html(listing))
    assert re.findall(r"[a-z]+$", text.strip()) and text.index("rpm") < text.index("lap")
    assert Listing(title="", heads=("a", "b"), rows=(Row("x", None, ("p", "q")),)).unit_place == 2


def test_a_drawing_names_no_input_that_comes_of_parameters(written):
    """The valve is told below which pressure oil evaporates: nothing that a line of the drawing could lead to."""
    said = words(written)
    assert wording.report.axial_position in said
    assert wording.report.cavitation_pressure not in said and wording.report.cavitation_limit not in said


def test_a_run_that_balances_is_trusted(written):
    said = words(written)
    assert wording.report.balances in said and wording.report.does_not_balance not in said


def test_a_run_that_does_not_balance_is_marked(orifice):
    edit(orifice / "summary.json", trusted=False, energy_residual=3.2e-4)
    text = page(orifice)
    assert f'<li class="bad">{wording.report.does_not_balance}</li>' in text
    assert "3.20·10⁻⁴" in text or "0.000320" in text
    assert "run.relative_tolerance" in text


@pytest.mark.parametrize(
    ("changes", "expected"),
    [
        (
            {"within_validity": False, "pressure_min_inlet_Pa": -0.9e5},
            wording.report.lowest_pressure.format(place="inlet", pressure="0.1133 bar"),
        ),
        (
            {"second_law": False, "loss_pump_friction_W": -5.0},
            wording.report.gives_energy_back.format(loss="loss_pump_friction_W"),
        ),
        ({"efficiency": None, "stored_power_W": 900.0}, wording.report.into_store),
        ({"motor_overloaded": True, "input_power_W": 6000.0}, wording.report.on_average.format(power="6000 W")),
        ({"settled": False}, wording.report.not_settled_title),
        ({"stiff_method": True}, wording.report.stiff_method),
    ],
)
def test_what_lies_outside_its_bounds_is_said_with_numbers(orifice, changes, expected):
    edit(orifice / "summary.json", **changes)
    shown = run_result(open_run(orifice))
    said = [f"{n.title} {n.text} {n.remedy}" for n in shown.findings] + [b.words for b in shown.badges]
    assert expected in " ".join(said)


@pytest.mark.parametrize(
    ("name", "settings", "badge"),
    [
        ("prototype", [], Badge(wording.report.not_settled, Grade.WARNING)),
        (
            "prototype",
            ["operation.duty_ratio={step=['0.5','0.4'], at='0.15 s'}"],
            Badge(wording.report.varies_by_design),
        ),
        (
            "prototype",
            ["operation.duty_ratio={step=['0.5','0.4'], at='0.02 s'}"],
            Badge(wording.report.not_settled, Grade.WARNING),
        ),
        ("displacement-chapter6", [], Badge(wording.report.varies_by_design)),
    ],
)
def test_screen_badge_and_finding_agree_on_what_should_have_settled(name, settings, badge):
    """A run that is over too early is warned of; where inputs vary where means are taken, or motion is the purpose,
    nothing is amiss."""
    run = run_system(load_system(name, settings, "0.2 s"))
    assert not run.has("settled")
    shown, expected = run_result(run), badge.grade is Grade.WARNING
    assert badge in shown.badges
    assert any(each.title == wording.report.not_settled_title for each in shown.findings) is expected
    assert (
        any(line.startswith(wording.report.not_settled_because) for line in warnings(run.system, run.summary))
        is expected
    )


def test_the_cavitation_numbers_are_printed_with_what_they_mean(whole, written):
    run = open_run(whole)
    listing = key_listings(run)["overview"]
    assert any(row.label.startswith(wording.report.cavitation_number) for row in listing.rows)
    assert wording.report.evaporates.format(number=f"{CAVITATION_NUMBER:g}") in listing.note
    assert OVERVIEW_NOTE in words(written)


def test_text_of_a_user_cannot_become_markup(orifice):
    path = orifice / "system.toml"
    text = path.read_text().replace('title = "Prototype', 'title = "<script>alert(1)</script> & Prototype')
    path.write_text(text.replace('note = "open', 'note = "<b>').replace('"wang2017"', '"<i>someone</i>"'))
    list_all(orifice)
    said = page(orifice)
    assert "<script>alert" not in said and "<i>someone" not in said
    assert "&lt;script&gt;alert(1)&lt;/script&gt; &amp; Prototype" in said
    assert wording.report.not_in_bibliography + ": &lt;i&gt;someone&lt;/i&gt;" in said


def test_a_pressure_source_takes_the_spectrum_of_the_inlet(constant):
    said = words(page(constant))
    assert wording.report.inlet_amplitude in said
    assert "Nodes" in said and "load line" in said and "area:" not in said


def test_a_run_without_marks_still_gives_a_report(standing):
    said = words(page(standing))
    assert wording.report.no_period in said
    assert wording.report.too_few_periods in said and wording.report.end_of_run in said
    assert not (standing / "figures" / "cycle-angle.svg").exists()


def test_an_interrupted_run_says_so(interrupted):
    text = page(interrupted)
    assert '<li class="bad">interrupted</li>' in text
    assert "of 2 s" in words(text)
    assert wording.report.ended_before in words(text)


@pytest.mark.parametrize(
    ("window", "expected"),
    [("100 ms", wording.report.last_periods.format(count=3)), ("40 ms", wording.report.last_periods.format(count=2))],
)
def test_few_periods_are_shown_as_they_are(window, expected):
    run = run_system(load_system("prototype", [f'run.window="{window}"'], "0.1 s"))
    assert expected in run_result(run).charts["cycle-time"].caption


def test_a_run_in_memory_gives_the_result_of_its_directory(whole):
    system = load_system("prototype", ['run.window="0.1 s"'], "0.2 s")
    here, there = run_result(run_system(system)), run_result(open_run(whole))
    assert here.charts == there.charts
    for name, table in here.tables.items():
        for key, column in table.columns.items():
            assert column.values.tobytes() == there.tables[name].columns[key].values.tobytes(), key
            assert column.kind == there.tables[name].columns[key].kind
    timed = {"wall_time_s"}
    assert {k: n for k, n in here.numbers.items() if k not in timed} == {
        k: n for k, n in there.numbers.items() if k not in timed
    }


def test_every_number_of_a_summary_has_a_kind(whole):
    run = open_run(whole)
    unknown = run.numbers.keys() - quantities(run.system).keys()
    assert unknown == set()


def test_figures_of_an_earlier_report_do_not_stay(orifice):
    stale = orifice / "figures" / "old.svg"
    with write_listed(orifice, ["figures/old.svg"], pages=True):
        stale.write_text("<svg/>")
    write_report(orifice)
    assert not stale.exists()


def test_what_is_no_result_directory_is_refused(tmp_path):
    with pytest.raises(ConfigError, match=wording.files.is_no_result):
        write_report(tmp_path)
    with pytest.raises(ConfigError, match=wording.files.no_directory):
        write_report(tmp_path / "none")


def test_a_system_that_cannot_be_read_is_refused_before_anything_is_written(orifice):
    (orifice / "system.toml").write_text('circuit = "none"\n')
    list_all(orifice)
    with pytest.raises(ConfigError):
        write_report(orifice)
    assert not (orifice / "report.html").exists() and not (orifice / "figures").exists()


def test_project_and_customer_stay_with_the_result(orifice):
    from vvdp.results.store import add_labels

    add_labels(orifice, {"project": "Press 7 <b>", "customer": ""})
    add_labels(orifice, {"project": "", "customer": "ACME"})
    said = page(orifice)
    assert "Project <b>Press 7 &lt;b&gt;</b>" in said
    assert "For <b>ACME</b>" in said


def test_a_report_at_once_is_that_of_the_directory(orifice, whole, written):
    assert write_report(orifice, open_run(whole)).read_text("utf-8") == written


def test_a_page_of_a_run_is_light(written):
    assert len(written.encode()) < 1_000_000


def test_a_duty_ratio_that_changes_is_drawn_as_it_was_prescribed():
    prescribed = 'operation.duty_ratio={sine="0.5", amplitude="0.1", frequency="50 Hz"}'
    run = run_system(load_system("prototype", [prescribed], "0.03 s"))
    drawn = run_result(run).tables["series"]["duty_ratio"]
    assert drawn == pytest.approx(0.5 + 0.1 * np.sin(2.0 * np.pi * 50.0 * run.times), abs=1e-12)
    assert np.ptp(drawn) > 0.19


def test_the_lead_of_a_run_has_its_headline_its_powers_and_its_largest_losses(whole):
    run = open_run(open_directory(whole))
    rows = lead(run).rows
    values = {(row.group, row.label): row.values[0] for row in rows}
    assert len(rows) <= 12 and next(row.label for row in rows if row.group == "Result") == "efficiency"
    parts = sorted((loss.simulated for loss in components(run)), reverse=True)
    losses = [value for (group, _), value in values.items() if group == "Largest losses"]
    assert losses == pytest.approx([sum(parts), *parts[:3]])
    assert values["Power", "input power"] == pytest.approx(run.number("input_power_W"), rel=1e-6)
    shares = [float(row.note.split()[0]) for row in rows if row.group == "Largest losses" and row.note]
    assert shares == pytest.approx([100.0 * part / sum(parts) for part in parts[:3]], abs=0.05)


def test_all_warnings_stand_in_one_box_and_only_the_first_are_open(tmp_path):
    found = [Finding(title=f"note {n}", text="text", grade=Grade.WARNING) for n in range(5)]
    result = Result(verb="map", title="a", system="", findings=tuple(found))
    page = write_result_page(tmp_path, Page(result, {})).read_text("utf-8")
    assert page.count('<div class="notice') == 1 and "<summary>2 more</summary>" in page
