"""Tables as people write them."""

import json

import pytest
from tests.cli.conftest import vvdp  # noqa: F401


@pytest.fixture
def write(tmp_path):
    """A table of the given text; its path."""

    def make(text, name="table.csv"):
        path = tmp_path / name
        path.write_text(text, "utf-8")
        return path

    return make


@pytest.fixture
def fit(vvdp, tmp_path):  # noqa: F811
    """What `vvdp fit --json` says of a table."""

    def call(table, *words):
        answer = vvdp("fit", str(table), *words, "--json", "--no-report", "--force", "--out", str(tmp_path / "out"))
        assert answer.code == 0, answer.err
        return json.loads(answer.out)

    return call
