"""Between which values a reference lies that consists of signals, filters and products."""

import pytest

from vvdp.base.tables import parsed_table
from vvdp.evaluation.control_stages import range_asked
from vvdp.systems.system import built_system

TEXT = """
[nodes]
tank = { type = "tank" }
line = { type = "volume", volume = "0.5 l", start = "20 bar" }

[components]
drain = { type = "orifice", a = "line", b = "tank", area = "2 mm^2" }

[programs.turned]
type = "product"
first = { ramp = ["-2", "1"], from = "0.1 s", to = "0.2 s" }
second = { ramp = ["3 mm", "-5 mm"], from = "0.2 s", to = "0.3 s" }

[programs.smoothed]
type = "low-pass"
reads = "turned.value"
time_constant = "10 ms"

[programs.thrice]
type = "product"
first = "smoothed.value"
second = "-3"

[programs.looked]
type = "table"
reads = "turned.value"
places = ["0 mm", "1 mm"]
values = ["0 mm", "1 mm"]

[programs.measured]
type = "product"
first = "thrice.value"
second = "line.pressure"

[programs.kept]
type = "limit"
reads = "thrice.value"
highest = "4 mm"

[programs.capped]
type = "limit"
reads = "measured.value"
lowest = "-2 mm*bar"
highest = "5 mm*bar"

[programs.half]
type = "limit"
reads = "measured.value"
highest = "5 mm*bar"

[programs.shifted]
type = "limit"
reads = "turned.value"
lowest = "12 mm"

[programs.controlled]
type = "pi"
reads = "line.pressure"
reference = "30 bar"
gain = "1 mm/bar"
reset_time = "1 s"
lowest = "1 mm"
highest = "7 mm"

[run]
until = "0.1 s"
"""


@pytest.mark.parametrize(
    ("reference", "low", "high"),
    [
        ("turned.value", -6e-3, 10e-3),
        ("smoothed.value", -6e-3, 10e-3),
        ("thrice.value", -30e-3, 18e-3),
        ("kept.value", -30e-3, 4e-3),
        ("capped.value", -200.0, 500.0),
        ("shifted.value", 12e-3, 12e-3),
        ("controlled.value", 1e-3, 7e-3),
    ],
)
def test_the_ends_of_a_product_are_those_of_a_pair_of_ends_within_limits(reference, low, high):
    """-2 to 1 times -5 to 3 mm: the pairs give 10, -6, -5 and 3 mm; times -3 they are -30, 18, 15 and -9 mm."""
    network = built_system(parsed_table(TEXT, "asked.toml"), "asked").circuit.network
    assert range_asked(network, reference) == pytest.approx((low, high))


@pytest.mark.parametrize("reference", ["looked.value", "measured.value", "half.value", "line.pressure"])
def test_nothing_is_known_of_what_is_measured_or_looked_up(reference):
    network = built_system(parsed_table(TEXT, "asked.toml"), "asked").circuit.network
    assert range_asked(network, reference) is None
