"""The programs by the names that a system file uses."""

from collections.abc import Mapping

from vvdp.network.program import ProgramType
from vvdp.programs.unloading import UNLOADING

PROGRAMS: Mapping[str, ProgramType] = {"unloading": UNLOADING}
"""Programs that a system file can name, by their type."""
