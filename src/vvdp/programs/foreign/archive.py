"""The file of a foreign FMU: a zip archive from an unknown source, of which only the necessary entries are unpacked."""

import stat
import zipfile
import zlib
from dataclasses import dataclass
from pathlib import Path

from vvdp.base.errors import ParameterError
from vvdp.programs.foreign.description import Description, read_description
from vvdp.programs.foreign.platforms import this_platform

DESCRIPTION = "modelDescription.xml"
MOST_DESCRIPTION, MOST_BYTES, MOST_ENTRIES = 2**25, 2**30, 20_000
"""Bytes of a description and of all that is unpacked, and entries of an archive, beyond which it is refused."""


@dataclass(frozen=True)
class Archive:
    """The file of an FMU with its description; nothing is unpacked yet."""

    path: Path
    description: Description
    entries: tuple[str, ...]

    @property
    def platforms(self) -> list[str]:
        """The folders for which it has a binary of its model."""
        found = (name.split("/") for name in self.entries if name.startswith("binaries/"))
        stem = self.description.identifier
        return sorted({p[1] for p in found if len(p) == 3 and Path(p[2]).stem == stem})

    @property
    def binary(self) -> str:
        """The entry with the machine code for this machine. Raises ParameterError if there is none."""
        folder = this_platform().folder(self.description.fmi)
        name = f"binaries/{folder}/{self.description.identifier}{this_platform().end}"
        if name not in self.entries:
            there = f"it is for {', '.join(self.platforms)}" if self.platforms else "there is none at all"
            raise ParameterError(f"the FMU has no binary for {folder}; {there}")
        return name

    def unpack(self, folder: Path) -> Path:
        """Unpacks the binary with what lies beside it, and the resources, into `folder`; the path of the binary."""
        beside = self.binary.rpartition("/")[0] + "/"
        with zipfile.ZipFile(self.path) as file:
            for name in self.entries:
                if name.startswith((beside, "resources/")) and not name.endswith("/"):
                    target = folder / name
                    target.parent.mkdir(parents=True, exist_ok=True)
                    target.write_bytes(_content(file, name, MOST_BYTES))
        (folder / "resources").mkdir(exist_ok=True)
        return folder / self.binary


def open_archive(path: Path) -> Archive:
    """The FMU in a file. Raises ParameterError, in one sentence, if it cannot be used."""
    try:
        with zipfile.ZipFile(path) as file:
            infos = file.infolist()
            _check_entries(infos)
            names = tuple(info.filename for info in infos)
            if DESCRIPTION not in names:
                raise ParameterError(f"the file has no {DESCRIPTION}; it is not an FMU")
            description = read_description(_content(file, DESCRIPTION, MOST_DESCRIPTION))
    except FileNotFoundError:
        raise ParameterError("there is no such file") from None
    except (OSError, zipfile.BadZipFile, NotImplementedError) as problem:
        raise ParameterError(f"the file is not a zip archive that can be read ({problem})") from None
    return Archive(path, description, names)


def _check_entries(infos: list[zipfile.ZipInfo]) -> None:
    """Raises ParameterError for entries that lead out of a folder, are links, or are too many or too large."""
    for info in infos:
        name = info.filename
        if ".." in name.split("/") or name.startswith("/") or "\\" in name or ":" in name or "\0" in name:
            raise ParameterError(f"the archive has an entry {name!r}, which would lead out of its folder")
        if stat.S_ISLNK(info.external_attr >> 16):
            raise ParameterError(f"the archive has an entry {name!r}, which is a link")
    size = sum(info.file_size for info in infos)
    if len(infos) > MOST_ENTRIES or size > MOST_BYTES:
        raise ParameterError(
            f"the archive has {len(infos)} entries of {size / 2**20:.0f} MB unpacked; expected at most "
            f"{MOST_ENTRIES} of {MOST_BYTES // 2**20} MB"
        )


def _content(file: zipfile.ZipFile, name: str, most: int) -> bytes:
    """Content of an entry, of at most so many bytes, whatever size the archive states."""
    if (size := file.getinfo(name).file_size) > most:
        raise ParameterError(f"{name} has {size / 2**20:.0f} MB; expected at most {most // 2**20} MB")
    try:
        with file.open(name) as entry:
            content = entry.read(most + 1)
    except (zipfile.BadZipFile, zlib.error, EOFError, RuntimeError, NotImplementedError) as problem:
        raise ParameterError(f"{name} cannot be unpacked ({problem})") from None
    if len(content) > most:
        raise ParameterError(f"{name} has more than {most // 2**20} MB")
    return content
