"""A number of a run and the range in which a law holds."""

import math
from dataclasses import dataclass

from vvdp.base.display import with_unit
from vvdp.base.kinds import Kind


@dataclass(frozen=True, kw_only=True)
class Bound:
    """A number of a run, from `low` to `high`, that must lie between `least` and `most` for a law to hold."""

    label: str
    kind: Kind
    low: float
    high: float
    least: float = -float("inf")
    most: float = float("inf")
    otherwise: str

    @property
    def is_kept(self) -> bool:
        """Whether the number lies inside; one that is not known does."""
        return not (self.low < self.least or self.high > self.most)

    @property
    def sentence(self) -> str:
        """The sentence for a number that lies outside."""
        under = self.low < self.least
        value, limit = (self.low, self.least) if under else (self.high, self.most)
        least, most, found = (with_unit(number, self.kind) for number in (self.least, self.most, value))
        limits = f"{'below' if under else 'above'} {with_unit(limit, self.kind)}"
        if math.isfinite(self.least) and math.isfinite(self.most):
            limits = f"outside {least} to {most}"
        return f"{self.label}: {found}, {limits}; {self.otherwise}"
