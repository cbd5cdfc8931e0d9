"""The config of an estimation: defaults, everything wrong told at once with its place, and written back."""

import dataclasses

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from tests.words import wording

from vvdp.base.errors import ConfigError
from vvdp.base.tables import write_new
from vvdp.estimation.event_settings import event_filter
from vvdp.estimation.pressure_edges import pressure_edges
from vvdp.logs.channel import ChannelInfo
from vvdp.offline.config import (
    Comparator,
    Counts,
    Estimation,
    InletPressure,
    Option,
    Stamps,
    Wave,
    load_estimation,
)
from vvdp.offline.config_text import config_text
from vvdp.sensing.wheel import equal_wheel, wheel_of_widths

USUAL = Comparator(None, 0.25, True, False)


def loaded(tmp_path, text, *options):
    path = tmp_path / "estimate.toml"
    path.write_text(text, "utf-8")
    return load_estimation(path, options)


def told(tmp_path, text, *options):
    with pytest.raises(ConfigError) as refused:
        loaded(tmp_path, text, *options)
    return [str(fault) for fault in refused.value.faults]


def test_one_option_is_enough():
    wanted = load_estimation(None, [Option("sensor.wave", "--wave", "photodiode")])
    assert wanted.source == Wave("photodiode", USUAL)
    assert wanted.filter == event_filter(equal_wheel(8))
    assert wanted.sections == 3 and wanted.pressure is None and not wanted.smooth


def test_a_file_is_read_in_units(tmp_path):
    wanted = loaded(
        tmp_path,
        """
        [log]
        sample_rate = "10 kHz"
        from = "500 ms"
        [sensor]
        counts = "counter"
        widths = [1.25, 0.75, 1, 1]
        [filter]
        acceleration_density = "25 rad^2/s^3"
        lowest_speed = "120 rpm"
        [valve]
        sections = 4
        [pressure]
        channel = "inlet"
        unit = "psi"
        least_swing = "3 bar"
        fuse = true
        [output]
        rate = "2 kHz"
        smooth = true
        """,
    )
    assert wanted.source == Counts("counter")
    assert wanted.wheel == wheel_of_widths([1.25, 0.75, 1, 1])
    assert wanted.sample_rate == 10_000.0 and wanted.begin == 0.5
    assert wanted.filter.acceleration_density == 25.0
    assert wanted.filter.lowest_speed == pytest.approx(4.0 * np.pi)  # 120 rpm are two turns a second
    assert wanted.pressure is not None and wanted.pressure.edges.least_swing == 3e5 and wanted.pressure.fused
    assert (wanted.sections, wanted.output_rate, wanted.smooth) == (4, 2000.0, True)


def test_all_faults_are_told_at_once_with_line_and_key(tmp_path):
    lines = told(
        tmp_path,
        '[sensor]\nwave = "w"\nsectors = 7\nindexshift = 0.2\n[threshold]\nhysteresis = "3 V"\n'
        '[filter]\nedge_variance = "0.1 rad"\n[valve]\nsections = 0\n[outputs]\nrate = "1 kHz"\n'
        '[pressure]\nunit = "bar"\n',
    )
    joined = "\n".join(lines)
    for piece in (
        ":3: sensor.sectors: " + wording.estimate.alternate.format(count=7),
        ":4: sensor.indexshift: " + wording.files.unknown_key.format(meant="index_shift"),
        ":6: threshold.hysteresis:",
        ":8: filter.edge_variance: '0.1 rad' "
        + wording.files.is_not_a.format(quantity="an angular variance")
        + "; "
        + wording.files.use_one_of.format(units="rad^2"),
        ":10: valve.sections: " + wording.estimate.whole_number_from.format(value=0, low=1) + " to 100",
        ":11: outputs: " + wording.files.unknown_table + "; " + wording.files.did_you_mean.format(name="output"),
        ":14: pressure.unit: " + wording.estimate.belongs_to.format(key="pressure.channel"),
    ):
        assert piece in joined, joined
    assert len(lines) == 7


@pytest.mark.parametrize(
    ("text", "piece"),
    [
        ("[sensor]\nsectors = 8\n", wording.estimate.no_channel_named),
        (
            '[sensor]\nwave = "a"\ncounts = "b"\n',
            wording.estimate.given_one_of.format(one="sensor.wave", other="sensor.counts"),
        ),
        ('[sensor]\nwave = "a"\nfalling = "b"\n', wording.estimate.belongs_to_edges),
        ('[sensor]\nedges = "a"\nfalling = "a"\n', wording.estimate.rising_as_well),
        ('[sensor]\ncounts = "a"\n[threshold]\nlevel = 2.0\n', wording.estimate.belongs_to_wave),
        ("[sensor]\nwave = 3\n", wording.estimate.name_in_quotes),
        ('[sensor]\nwave = "a"\n[threshold]\nlevel = "high"\n', wording.estimate.automatic_or_number),
        ('[sensor]\nwave = "a"\n[threshold]\nlevel = nan\n', wording.estimate.not_finite),
        ('[sensor]\nwave = "a"\n[threshold]\nhysteresis = 0.95\n', wording.estimate.no_edge_seen),
        ('[sensor]\nwave = "a"\nwidths = [1, 1]\nsectors = 2\n', wording.files.contradicts.format(key="sensor.widths")),
        ('[sensor]\nwave = "a"\nwidths = [1, -1]\n', wording.estimate.all_above_zero),
        ('[sensor]\nwave = "a"\nwidths = [1, "x"]\n', wording.estimate.one_for_each),
        ('[sensor]\nwave = "a"\nindex_shift = 2\n', wording.files.expected_range.format(low=-0.9, high=0.9)),
        ('[sensor]\nwave = "a"\nindex_shift = "much"\n', wording.estimate.share_of_a_sector),
        ('[sensor]\nwave = "a"\ninverted = 1\n', wording.estimate.true_or_false),
        (
            '[sensor]\nwave = "a"\n[log]\nfrom = "3 s"\nuntil = "2 s"\n',
            wording.estimate.not_after.format(key="log.from"),
        ),
        ('[sensor]\nwave = "a"\n[log]\ntime = "t"\nsample_rate = "1 kHz"\n', wording.estimate.one_of_them),
        ('[sensor]\nwave = "a"\n[log]\ntime_unit = "bar"\n', "bar"),
        ('[sensor]\nwave = "a"\n[log]\nsample_rate = "0 Hz"\n', wording.files.greater_than_zero),
        ('[sensor]\nwave = "a"\n[filter]\nedge_variance = "0 rad^2"\n', wording.files.greater_than_zero),
        ('[sensor]\nwave = "a"\n[pressure]\nchannel = "p"\nhysteresis = 0.9\n', wording.estimate.reaches_plateau),
        ('[sensor]\nwave = "a"\n[pressure]\nchannel = "p"\nunit = "kg"\n', "kg"),
        ("sensor = 3\n", wording.estimate.expected_table),
        ("[sensor\n", wording.files.is_not_toml),
        ("", wording.files.is_empty),
    ],
)
def test_each_fault_is_told(tmp_path, text, piece):
    lines = told(tmp_path, text)
    assert any(piece in line for line in lines), lines


def test_an_option_goes_before_the_file_and_is_named_in_its_faults(tmp_path):
    text = '[sensor]\nwave = "w"\nsectors = 8\n'
    assert loaded(tmp_path, text, Option("sensor.counts", "--counts", "c")).source == Counts("c")
    assert len(loaded(tmp_path, text, Option("sensor.sectors", "--sectors", 10)).wheel.edges) == 10
    lines = told(tmp_path, text, Option("sensor.sectors", "--sectors", 9))
    assert lines == ["--sectors: " + wording.estimate.alternate.format(count=9)]


sources = st.one_of(
    st.builds(
        Wave,
        st.text(min_size=1).filter(str.strip),
        st.builds(
            Comparator,
            st.none() | st.floats(-1e6, 1e6),
            st.floats(0.0, 0.9),
            st.booleans(),
            st.booleans(),
        ),
    ),
    st.just(Counts("a b")),
    st.just(Stamps("rise", "fall")),
    st.just(Stamps("edge")),
)
wheels = st.one_of(
    st.builds(equal_wheel, st.integers(1, 20).map(lambda n: 2 * n), st.floats(-0.9, 0.9)),
    st.lists(st.floats(0.1, 2.0), min_size=4, max_size=4).map(wheel_of_widths),
)


@given(sources, wheels, st.none() | st.floats(1.0, 1e5), st.booleans(), st.booleans())
@example(Wave('\x7f\x00\n"\\ \u2028', Comparator(None, 0.25, True, False)), equal_wheel(8), None, False, False)
@example(Counts("a b"), equal_wheel(38, 0.8999999999999999), None, False, False)
def test_what_is_written_reads_back_the_same(tmp_path_factory, source, wheel, rate, pressed, smooth):
    if isinstance(source, Wave) and any(c in source.channel for c in "\ud800\udfff"):
        return
    pressure = InletPressure("p in", "bar", pressure_edges(), True, 0.08, 2e-4, 1e-4) if pressed else None
    wanted = Estimation(
        source, event_filter(wheel), 3, output_rate=rate, pressure=pressure, smooth=smooth, begin=-1.5, end=1e9
    )
    path = tmp_path_factory.mktemp("written") / "c.toml"
    text = config_text(wanted, [ChannelInfo("a\nb", "V", 3, "")])
    path.write_text(text, "utf-8")
    again = load_estimation(path)
    assert np.allclose(again.wheel.edges, wheel.edges, rtol=0.0, atol=1e-9)
    assert dataclasses.replace(again, filter=wanted.filter) == wanted
    assert dataclasses.replace(again.filter, wheel=wheel) == wanted.filter


def test_a_config_is_not_written_over_another(tmp_path):
    path = tmp_path / "c.toml"
    write_new(path, "a", force=False)
    with pytest.raises(ConfigError, match=wording.files.already_exists):
        write_new(path, "b", force=False)
    write_new(path, "b", force=True)
    assert path.read_text() == "b"
    with pytest.raises(ConfigError, match=wording.files.cannot_write):
        write_new(tmp_path / "none" / "c.toml", "a", force=False)
