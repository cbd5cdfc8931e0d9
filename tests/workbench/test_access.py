"""No view of the page has what axe calls serious, in either scheme; the order of focus is that of the page."""

import pytest
from tests.report.axe import serious
from tests.workbench.steps import COMPLETE, DUTY, enter, wait_for


def prefer(page, scheme):
    page.call("Emulation.setEmulatedMedia", features=[{"name": "prefers-color-scheme", "value": scheme}])


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_axe_finds_nothing_serious(page, scheme):
    prefer(page, scheme)
    assert serious(page) == []


@pytest.mark.thorough
@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_axe_finds_nothing_serious_in_any_view(page, scheme):
    """All that can be open at once: series, compared runs, logs, palette, joints, a fault; then text, then lesson."""
    prefer(page, scheme)
    enter(page, "document.getElementById('series')", "inlet_pressure", "change")
    wait_for(page, "live.has('series')")
    enter(page, DUTY, "0.4", "change")
    wait_for(page, f"{COMPLETE} && state.runs.length === 2")
    page.ask("document.querySelectorAll('#runs input').forEach((each) => each.click())")
    assert page.ask("document.querySelectorAll('#compared tr').length") > 5
    page.ask("document.getElementById('measured').open = true; document.getElementById('draw').click()")
    wait_for(page, "document.querySelectorAll('#palette-list button').length > 70")
    page.ask("openTable('pump')")
    enter(page, DUTY, "7", "change")
    wait_for(page, "document.querySelectorAll('.wrong').length === 1")
    assert serious(page) == []
    page.ask("document.getElementById('tab-text').click()")
    assert serious(page) == []
    page.ask("document.getElementById('open-teach').click()")
    assert serious(page) == []
    page.ask("document.getElementById('close-teach').click(); document.getElementById('draw').click()")


def test_a_violation_is_found(page):
    page.ask("document.getElementById('filter').removeAttribute('aria-label')")
    page.ask("document.getElementById('filter').removeAttribute('placeholder')")
    assert [rule for rule, *_ in serious(page)] == ["label"]


def test_focus_goes_through_the_page_in_its_order(page):
    """Tab visits what can be used in the order of the document, with a visible ring."""
    page.ask("document.activeElement.blur()")
    places = []
    for _ in range(25):
        page.call("Input.dispatchKeyEvent", type="rawKeyDown", key="Tab", code="Tab", windowsVirtualKeyCode=9)
        seen = "[...document.querySelectorAll('*')].indexOf(document.activeElement)"
        ring = "document.activeElement.matches(':focus-visible')"
        places.append(page.ask(seen))
        assert page.ask(ring)
    assert places == sorted(set(places)) and len(places) == 25
