"""The report as a browser shows and prints it."""

import re
import shutil
import subprocess

import pytest
from tests.report.browser import QUIET

from vvdp.report.report import write_report


@pytest.fixture(scope="module")
def printed(whole, chromium, tmp_path_factory):
    """The report printed to PDF by a browser, and what the browser said."""
    folder = tmp_path_factory.mktemp("browser")
    pdf = folder / "report.pdf"
    directory = shutil.copytree(whole, folder / "result")
    done = subprocess.run(
        [
            chromium,
            *QUIET,
            f"--user-data-dir={folder / 'profile'}",
            "--enable-logging=stderr",
            f"--print-to-pdf={pdf}",
            write_report(directory).as_uri(),
        ],
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return pdf.read_bytes(), done.stderr


def test_prints_on_several_pages(printed):
    pages = len(re.findall(rb"/Type\s*/Page\b", printed[0]))
    assert 5 <= pages <= 20  # head, course, losses, computation, parameters: a table must not run off one long page


def test_console_is_late(printed):
    assert "CONSOLE" not in printed[1]
