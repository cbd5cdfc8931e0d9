"""The state that limits the steps of a run: the one whose error is largest, with the size of what it belongs to."""

from collections import Counter
from typing import Any

import numpy as np

from vvdp.base.display import value_text
from vvdp.base.kinds import INERTIA, MASS, VOLUME
from vvdp.base.params import Params, field_kinds
from vvdp.simulation.model import Case
from vvdp.simulation.prepare import Prepared
from vvdp.simulation.values import leaves

SIZES = (VOLUME, MASS, INERTIA)
"""Kinds of the values that make a state fast if they are small."""


class LimitingState:
    """Counts, between the portions of a run, which state had the largest error in the last step."""

    def __init__(self, case: Case, ready: Prepared, bench: Any) -> None:
        self.case, self.ready, self.bench = case, ready, bench
        self.counts: Counter[int] = Counter()

    def count(self, state: Any) -> int | None:
        """Count the state that limited the last step, which ended or was refused at `state` (n,); its place.

        None in a circuit without a state, whose steps nothing limits.
        """
        active = self.ready.pattern.group.size
        if active == 0:
            return None
        size = np.fmax(np.abs(state[:active]), np.abs(self.bench.trial[:active]))
        with np.errstate(all="ignore"):
            errors = np.abs(self.bench.error[:active]) / (self.ready.atol[:active] + self.ready.rtol[:active] * size)
        place = int(np.argmax(np.nan_to_num(errors, nan=np.inf)))
        self.counts[place] += 1
        return place

    @property
    def words(self) -> str:
        """The state that was counted most, for a user: `middle (volume 0.01 cc)`; empty before the first count."""
        return state_words(self.case, self.counts.most_common(1)[0][0]) if self.counts else ""


def state_words(case: Case, place: int | None) -> str:
    """The state at this place by its path, with the volume, mass or inertia that it belongs to; empty for none."""
    if place is None:
        return ""
    path = [path for path, _, _ in leaves(case.state)][place]
    values = getattr(case.params, path.partition(".")[0], None)
    if not isinstance(values, Params):
        return path
    sizes = {key: kind for key, kind in field_kinds(type(values)).items() if kind in SIZES}
    texts = [f"{key.replace('_', ' ')} {value_text(getattr(values, key), kind)}" for key, kind in sizes.items() if kind]
    return f"{path} ({', '.join(texts)})" if texts else path
