"""A column of words has no unit."""

import pytest

from vvdp.base.errors import ConfigError
from vvdp.fitting.jet import COLUMNS
from vvdp.fitting.table import read_columns


def test_a_unit_in_the_heading_of_words_is_refused(tmp_path):
    path = tmp_path / "table.csv"
    text = "opening,torque [N*m],port\n0.2,0.11,closing\n0.5,0.25,opening\n"
    path.write_text(text)
    assert read_columns(path, COLUMNS)["port"].tolist() == [1.0, -1.0]
    path.write_text(text.replace("port", "port [psi]"))
    with pytest.raises(ConfigError, match=r"port: has the unit 'psi', but holds words"):
        read_columns(path, COLUMNS)
