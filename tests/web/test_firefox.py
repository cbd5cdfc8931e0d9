"""Pages in Firefox, where it is installed: the bits of the command line.

Outputs are calculated from the recorded states after a run, natively by code that may fuse a product and a sum.
"""

import numpy as np
import pytest
from tests.conftest import required_program
from tests.web.firefox import asked

from vvdp.runs.simulate import recorded_run
from vvdp.simulation.run import simulate
from vvdp.systems.system import load_system
from vvdp.web.page import web_page
from vvdp.web.series import table_courses

PLAIN = "JSON.stringify(series, (_, x) => (ArrayBuffer.isView(x) ? [...x] : x))"
SERIES = f"vvdp.run({{ level: 'exact' }}).then(({{ series }}) => {PLAIN})"


@pytest.mark.thorough
@pytest.mark.parametrize("name", ["cylinder-stops", "prototype"])
def test_firefox_has_the_bits_of_the_command_line(tmp_path, name):
    program = required_program("firefox-esr")
    system = load_system(name, (), "0.5 s")
    page = tmp_path / "page.html"
    made = web_page(system)
    page.write_text(made.html, "utf-8")
    found = asked(program, tmp_path / "profile", page, SERIES)
    run = recorded_run(system, simulate(system.model, system.case, system.stepping))
    expected = table_courses(run)
    assert len(found) > 5
    for key, values in found.items():
        rows = made.model["series"][key][0]
        np.testing.assert_array_max_ulp(np.array(values, float), expected[key], 4 if rows == "output" else 0)
