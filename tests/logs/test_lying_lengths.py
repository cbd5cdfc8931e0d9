"""No more memory is taken than a file can fill, whatever lengths it states; units that contradict are refused."""

import struct
import tracemalloc

import pytest
from tests.logs import hostile

from vvdp.base.errors import ConfigError
from vvdp.logs.source import open_log

MOST = 150e6
"""Memory that a file of some kilobytes may take [B]; its stated lengths are in gigabytes."""


def taken(path, channel):
    """The most memory that is taken while a channel is read or refused [B], and the refusal."""
    tracemalloc.start()
    try:
        with pytest.raises(ConfigError) as refused, open_log(path) as log:
            for _ in log.portions([channel], 250_000):
                pass
        return tracemalloc.get_traced_memory()[1], str(refused.value)
    finally:
        tracemalloc.stop()


def test_a_text_of_tdms_that_states_two_gigabytes(tmp_path):
    path = hostile._tdms(tmp_path / "a.tdms", struct.pack("<I", 2**31) + b"/'g'", 1, raw=bytes(80))
    most, said = taken(path, "v")
    assert most < MOST and "damaged or cut off" in said


def test_a_row_of_a_table_that_is_a_thousand_times_as_long_as_others(tmp_path):
    most, said = taken(hostile.long_field(tmp_path / "a.csv"), "v")
    assert most < MOST and said


def test_units_in_the_headings_and_others_below_them(tmp_path):
    path = tmp_path / "a.csv"
    path.write_text("time [s];position [kg]\ns;mm\n0;1\n1;2\n2;3\n")
    with pytest.raises(ConfigError, match=r"has the units 'kg' and, below, 'mm'"), open_log(path):
        pass
    path.write_text("time [s];position [mm]\ns;mm\n0;1\n1;2\n2;3\n")
    with open_log(path) as log:
        assert log.channel("position").unit == "mm"
