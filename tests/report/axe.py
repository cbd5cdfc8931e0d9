"""What axe-core finds on a page: violations that it calls serious or critical."""

from importlib import resources

import pytest

RUN = """axe.run(document, { iframes: false, resultTypes: ["violations"] }).then(({ violations }) => violations
  .filter(({ impact }) => impact === "serious" || impact === "critical")
  .map(({ id, nodes }) => [id, nodes[0].html.slice(0, 200), nodes[0].failureSummary]))"""


def serious(page):
    """Rule, element and reason of each serious violation on the page as it is now."""
    pytest.importorskip("axe_core_python")
    page.ask(f"{resources.files('axe_core_python').joinpath('axe.min.js').read_text('utf-8')}; 0")
    return page.ask(RUN)
