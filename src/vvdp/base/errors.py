"""Everything that vvdp refuses, as exceptions that a user can act on."""

from dataclasses import dataclass
from pathlib import Path


class VvdpError(Exception):
    """Base of all errors that are the user's to mend; the command line prints them without a traceback."""


class ParameterError(VvdpError, ValueError):
    """A value lies outside what its kind allows, or contradicts another value."""


class NetworkError(VvdpError, ValueError):
    """A component or a network does not fit together."""


class RunError(VvdpError, RuntimeError):
    """A simulation could not be carried to its end."""


class WriteError(VvdpError, OSError):
    """A file could not be written to the disk: number and words of the operating system, and the path."""

    def __str__(self) -> str:
        return f"{self.filename}: cannot be written ({self.strerror})"


@dataclass(frozen=True)
class Fault:
    """One thing wrong with a file: where it is, the key as the user wrote it, and what was expected."""

    place: str
    line: int
    key: str
    message: str

    def __str__(self) -> str:
        where = f"{self.place}:{self.line}" if self.line else self.place
        return f"{where}: {self.key}: {self.message}" if self.key else f"{where}: {self.message}"


class ConfigError(VvdpError, ValueError):
    """A file or an option cannot be used; carries every fault that was found, not only the first."""

    def __init__(self, faults: list[Fault]) -> None:
        self.faults = tuple(faults)
        super().__init__("\n".join(str(fault) for fault in faults))

    def __reduce__(self) -> tuple[type, tuple[list[Fault]]]:
        return type(self), (list(self.faults),)  # workers send it to who asked them


class UnknownKeyError(ConfigError, KeyError):
    """A key that a mapping does not have; says which of its keys were perhaps meant."""

    __str__ = VvdpError.__str__  # a KeyError would show the repr of its message


def unusable(path: Path | str, message: str) -> ConfigError:
    """A `ConfigError` about a file as a whole."""
    return ConfigError([Fault(str(path), 0, "", message)])
