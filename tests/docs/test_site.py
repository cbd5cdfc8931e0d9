"""The site: it builds without a warning, asks nothing of the network, and sets every formula."""

import html
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest
from tests.report.axe import serious
from tests.report.browser import running

from vvdp.systems.system import shipped_systems

pytestmark = pytest.mark.thorough

ROOT = Path(__file__).parents[2]
LOADED = re.compile(r"""<(?:script|img|link|iframe|source)\b[^>]*?\b(?:src|href)=["']?(\w+:)?//""")
"""What a page would fetch from elsewhere; a link that a reader may follow is something else."""
FORMULA = re.compile(r'<(?:div|span) class="arithmatex">(.*?)</(?:div|span)>', re.DOTALL)


@pytest.fixture(scope="module")
def site(tmp_path_factory) -> Path:
    folder = tmp_path_factory.mktemp("site")
    command = [sys.executable, "-m", "mkdocs", "build", "--strict", "--site-dir", str(folder)]
    ended = subprocess.run(command, cwd=ROOT, env=_environment(), capture_output=True, text=True)
    assert ended.returncode == 0, ended.stdout + ended.stderr
    return folder


def _environment() -> dict[str, str]:
    circuits = {"VVDP_LIVE_PAGES": "press.toml,accumulator-charging"}
    return {**os.environ, "NO_MKDOCS_2_WARNING": "1", "PYTHONPATH": str(ROOT / "src"), **circuits}


def pages(site: Path) -> dict[str, str]:
    return {str(path.relative_to(site)): path.read_text("utf-8") for path in site.rglob("*.html")}


def in_browser(chromium: str, uri: str) -> str:
    """A page after its scripts have run, as HTML."""
    options = ["--headless", "--no-sandbox", "--disable-gpu", "--virtual-time-budget=20000", "--dump-dom"]
    return subprocess.run([chromium, *options, uri], capture_output=True, text=True, timeout=120).stdout


def test_every_door_is_there(site):
    found = pages(site)
    for name in ("index", "first-circuit", "command-line", "reference/verbs", "reference/python/hydraulics", "gallery"):
        assert f"{name}.html" in found
    assert {"Tutorials", "How-to", "Reference", "Explanation"} <= set(re.findall(r"[\w-]+", found["index.html"]))
    assert "vvdp rig pressure-drop" in found["reference/verbs.html"]
    assert "Volume flow through an orifice" in found["reference/python/hydraulics.html"]
    assert "merritt1967" in found["reference/literature.html"]


def test_nothing_comes_from_the_network(site):
    outside = {name: LOADED.findall(text) for name, text in pages(site).items() if LOADED.search(text)}
    assert not outside
    for path in site.rglob("*.css"):
        assert not re.search(r"(?:url\(|@import )['\"]?(?:https?:)?//", path.read_text("utf-8")), path


def test_the_search_works_from_a_file(site, chromium):
    found = in_browser(chromium, (site / "index.html").as_uri() + "?q=orifice")
    assert int(re.search(r"(\d+) matching documents", found)[1]) > 5


def test_licences_travel_with_what_they_cover(site):
    for name in ("katex", "iframe-worker"):
        assert "MIT" in (site / "assets" / name / "LICENSE").read_text("utf-8")


def test_every_formula_is_set(site, chromium, tmp_path):
    """All formulas of all pages on one, set by the KaTeX of the site in a browser."""
    formulas = [each for text in pages(site).values() for each in FORMULA.findall(text)]
    assert len(formulas) > 200
    assets = (site / "assets").as_uri()
    spans = "\n".join(f'<div class="arithmatex">{each}</div>' for each in [*formulas, r"\(\wrong{\)"])
    scripts = "".join(f'<script src="{assets}/{name}"></script>' for name in ("katex/katex.min.js", "formulas.js"))
    page = tmp_path / "formulas.html"
    page.write_text(f"<!doctype html><meta charset=utf-8>{spans}{scripts}", "utf-8")
    drawn = in_browser(chromium, page.as_uri())
    wrong = [html.unescape(each) for each in re.findall(r'class="katex-error"[^>]*title="([^"]*)"', drawn)]
    assert len(wrong) == 1 and "wrong" in wrong[0], wrong
    assert drawn.count('class="katex"') == len(formulas)


def test_a_broken_link_fails_the_build(tmp_path):
    (tmp_path / "docs").mkdir()
    (tmp_path / "docs" / "index.md").write_text("# Home\n\n[nowhere](missing.md)\n", "utf-8")
    kept = re.search(r"^validation:\n(?:  .*\n)+", (ROOT / "mkdocs.yml").read_text("utf-8"), re.MULTILINE)[0]
    (tmp_path / "mkdocs.yml").write_text(f"site_name: x\nstrict: true\n{kept}", "utf-8")
    command = [sys.executable, "-m", "mkdocs", "build"]
    ended = subprocess.run(command, cwd=tmp_path, env=_environment(), capture_output=True, text=True)
    assert ended.returncode != 0 and "missing.md" in ended.stdout + ended.stderr


def test_every_link_between_pages_leads_somewhere(site):
    """Those that MkDocs does not see, too: out of docstrings and generated pages; here two live pages are made."""
    import live_pages

    found = pages(site)
    made_by_make_docs = {f"{live_pages.FOLDER}/{name}.html" for name in live_pages.names()}
    anchors = {name: set(re.findall(r'\bid=["\']?([^"\'\s>]+)', text)) for name, text in found.items()}
    broken = []
    for name, text in found.items():
        if name == "404.html":  # its links are those of the root of a server
            continue
        for link in re.findall(r'<a\b[^>]*?\bhref=["\']?([^"\'\s>]+)', text):
            link = html.unescape(link)
            if re.match(r"[a-z]+:", link):
                continue
            path, _, anchor = link.partition("#")
            target = os.path.normpath(Path(name).parent / path) if path else name
            if target in made_by_make_docs:
                continue
            if not (site / target).is_file() or (anchor and target in anchors and anchor not in anchors[target]):
                broken.append((name, link))
    assert not broken


def test_circuits_run_in_the_site(site, chromium, tmp_path):
    """The first circuit below its text and by itself; what it shows first is what the page on it prints: 79.29 bar."""
    page = (site / "first-circuit.html").read_text("utf-8")
    frames = re.findall(r'<iframe src="([^"]+)"', page)
    assert frames == ["live/press.toml.html", "live/unit.toml.html"]
    assert (
        '<iframe src="../live/displacement-chapter6.html"' in (site / "subjects/displacement-control.html").read_text()
    )
    assert (site / "gallery.html").read_text("utf-8").count("<iframe src=") == len(shipped_systems()) - 2
    with running(chromium, tmp_path / "profile") as browser:
        browser.open(site / frames[0])
        found = browser.ask("vvdp.run({}).then(({ summary }) => summary.pressure_mean_rail_Pa)")
        assert found / 1e5 == pytest.approx(79.29, abs=5e-3)
        asked = [event["request"]["url"] for event in browser.named("Network.requestWillBeSent")]
        assert all(url.startswith(("file:", "blob:")) for url in asked)


SCROLLS = "document.documentElement.scrollWidth - document.documentElement.clientWidth"
TINY = """[...document.querySelectorAll('article *')].filter((each) => each.checkVisibility()
  && !each.closest('svg, .katex, sup, sub') && [...each.childNodes].some((one) => one.nodeType === 3 && one.data.trim())
  && parseFloat(getComputedStyle(each).fontSize) < 8.99).map((each) => each.outerHTML.slice(0, 80))"""
CHECKED = ("index", "first-circuit", "logs")
"""Pages that axe looks at: the home page, a tutorial with live circuits, a reference with code and tables."""


@pytest.mark.parametrize("width", [1400, 390])
def test_pages_fit_a_screen_and_a_phone(site, chromium, tmp_path, width):
    """No script error, no sideways scrolling, no text below 9 px; names and contrasts that axe asks for."""
    written = sorted(path for path in site.rglob("*.html") if not {"reference", "live"} & set(path.parts))
    assert len(written) > 50
    with running(chromium, tmp_path / "profile") as browser:
        browser.call("Emulation.setDeviceMetricsOverride", width=width, height=1000, deviceScaleFactor=1, mobile=False)
        for path in written:
            browser.open(path)
            assert (browser.ask(SCROLLS), browser.ask(TINY)) == (0, []), path.name
            assert browser.named("Runtime.exceptionThrown") == [], path.name
        for scheme in ("light", "dark"):
            browser.call("Emulation.setEmulatedMedia", features=[{"name": "prefers-color-scheme", "value": scheme}])
            for name in CHECKED:
                browser.open(site / f"{name}.html")
                assert serious(browser) == [], (name, scheme)
