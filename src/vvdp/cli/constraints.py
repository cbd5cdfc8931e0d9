"""Options that the questions of `vvdp design` share: what a design may be."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from vvdp.cli.options import Bounds, Cycle, Limits

if TYPE_CHECKING:
    from vvdp.design.problem import Problem
    from vvdp.systems.system import System


@dataclass(frozen=True)
class Constraints:
    """Options: what a design may be, and at which operating points it is judged."""

    subject_to: Limits = None
    bound: Bounds = None
    cycle: Cycle = None

    def problem(self, system: "System", minimise: str, beside: Sequence[str] = ()) -> "Problem":
        """The design problem of a system with them. Raises ParameterError where it is none."""
        from vvdp.design.problem import problem

        return problem(system, minimise, self.subject_to or (), self.bound or (), self.cycle, beside=beside)
