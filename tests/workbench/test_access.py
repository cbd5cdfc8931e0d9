"""Two rules that accessibility checkers call serious (WCAG 2.2, 4.1.2 and 1.4.3), by the browser's own tree."""

from pathlib import Path

import pytest
from tests.workbench.steps import wait_for

NAMED = ("button", "slider", "textbox", "searchbox", "combobox", "checkbox", "tab", "dialog")
CONTRASTS = (Path(__file__).parent / "contrast.js").read_text("utf-8")


@pytest.mark.parametrize("scheme", ["light", "dark"])
@pytest.mark.parametrize("view", ["draw", "measured", "open-teach"])
def test_everything_has_a_name_and_enough_contrast(page, view, scheme):
    page.call("Emulation.setEmulatedMedia", features=[{"name": "prefers-color-scheme", "value": scheme}])
    opening = "if ('open' in e) e.open = true; else e.click();"
    page.ask(f"(() => {{ const e = document.getElementById('{view}'); {opening} }})()")
    wait_for(page, f"document.querySelectorAll('#palette-list button').length > 70 || '{view}' !== 'draw'")
    found = [each for each in page.call("Accessibility.getFullAXTree")["nodes"] if not each["ignored"]]
    names = [each.get("name", {}).get("value", "") for each in found if each["role"]["value"] in NAMED]
    assert len(names) > 5 and all(name.strip() for name in names)
    contrasts = page.ask(CONTRASTS)
    assert len(contrasts) > 8
    assert [each for each in contrasts if each["ratio"] < each["least"]] == []
