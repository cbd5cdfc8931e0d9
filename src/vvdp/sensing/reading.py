"""Output of a data acquisition to an estimator."""

from typing import NamedTuple

from vvdp.base.kinds import Count, Number, Time


class Reading(NamedTuple):
    """One sample of an edge sensor.

    The last of `edges` edges since the sample before happened at `edge_time`, give or take half of `edge_interval`:
    a sampling period where only the samples show (the middle of it is then the edge time), 0 where a capture unit
    stamped the edge. `polarity` is that of the last edge: +1 rising, -1 falling, 0 unknown. Where `edges` is 0 the
    fields after it mean nothing.
    """

    time: Time
    edges: Count
    edge_time: Time
    edge_interval: Time
    polarity: Number
