"""The queue from which threads take the cases of a batch: the number of the next one, and whether all are to stop."""

from typing import Any

from vvdp.generator.kinds import INT, Intrinsic, Row
from vvdp.simulation.places import NEXT


def take(queue: Any) -> int:
    """The number of the next case, which is one more afterwards, whichever thread takes one at the same time."""
    number = int(queue[NEXT])
    queue[NEXT] += 1
    return number


TAKE = Intrinsic(
    name="vvdp_take",
    arguments=(Row(INT, (None,)),),
    text="""\
define internal i64 @vvdp_take(ptr %queue, i64 %length) alwaysinline nounwind {
  %number = atomicrmw add ptr %queue, i64 1 monotonic
  ret i64 %number
}""",
    plain=take,
    result=INT,
    is_pure=False,
)
