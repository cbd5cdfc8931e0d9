"""Machines for which an FMU may hold a binary: their folders by version of FMI, and the end of a library's name."""

import platform
import sys
from typing import NamedTuple

WINDOWS, DARWIN, LINUX = "windows", "darwin", "linux"
ENDS = {LINUX: ".so", DARWIN: ".dylib", WINDOWS: ".dll"}
PROCESSORS = {"amd64": "x86_64", "arm64": "aarch64"}
"""Names that systems have for the processors of FMI 3."""


class Platform(NamedTuple):
    """A processor and an operating system, by their names in FMI 3."""

    processor: str
    system: str

    def __str__(self) -> str:
        return f"{self.processor}-{self.system}"

    @property
    def end(self) -> str:
        """The end of a library's name."""
        return ENDS[self.system]

    def folder(self, fmi: int) -> str:
        """The folder of its binaries; FMI 2 names the size of an address alone."""
        return str(self) if fmi == 3 else f"{'win' if self.system == WINDOWS else self.system}64"


def this_platform() -> Platform:
    """The machine that runs."""
    processor = platform.machine().lower()
    system = {"win32": WINDOWS}.get(sys.platform, sys.platform)
    return Platform(PROCESSORS.get(processor, processor), system)
