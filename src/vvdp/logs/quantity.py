"""Channels as quantities: the unit that the file says, turned into SI of the kind that is expected."""

from pathlib import Path
from typing import NamedTuple

from vvdp.base.arrays import Array
from vvdp.base.errors import ConfigError, Fault, ParameterError
from vvdp.base.kinds import Kind
from vvdp.base.units import line_to_si
from vvdp.logs.channel import ChannelInfo


class Conversion(NamedTuple):
    """SI value = recorded value * factor + offset."""

    factor: float
    offset: float

    def __call__(self, values: Array) -> Array:
        return values * self.factor + self.offset


def to_si(path: Path, channel: ChannelInfo, kind: Kind, unit: str | None = None) -> Conversion:
    """How the values of a channel become SI of `kind`; `unit` is for a channel that has none written.

    A plain pressure unit on a level is gauge, as everywhere; where `bar` is written, `unit` may say `bara`. Raises
    ConfigError where the channel is something else, has no unit, or `unit` contradicts the one that is written.
    """
    if unit is not None and channel.unit and unit not in (channel.unit, f"{channel.unit}a", f"{channel.unit}g"):
        problem = f"is in {channel.unit!r} as the file says, not in {unit!r}"
        raise ConfigError([Fault(str(path), 0, channel.name, problem)])
    written = unit or channel.unit
    if not written and kind.unit != "1":
        problem = f"has no unit; {kind.with_article} was expected, say in {kind.display_unit or kind.unit}"
        raise ConfigError([Fault(str(path), 0, channel.name, problem)])
    try:
        return Conversion(*line_to_si(written, kind))
    except ParameterError as problem:
        raise ConfigError([Fault(str(path), 0, channel.name, f"is in {written!r}: {problem}")]) from None
