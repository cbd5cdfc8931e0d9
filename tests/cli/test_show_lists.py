"""`vvdp show --json` of every shipped system, also of those with empty lists of values."""

import json

import pytest
from tests.cli.conftest import vvdp  # noqa: F401

from vvdp.systems.system import shipped_systems


@pytest.mark.parametrize("name", shipped_systems())
def test_every_shipped_system_is_shown_as_json(vvdp, name):  # noqa: F811
    answer = vvdp("show", name, "--json")
    assert answer.code == 0
    shown = json.loads(answer.out)["parameters"]
    empty = [entry for entry in shown.values() if entry["value"] == []]
    assert all(entry["low"] is entry["high"] is None for entry in empty)
    assert empty or name != "axial-chamber"
