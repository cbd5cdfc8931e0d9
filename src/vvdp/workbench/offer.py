"""Systems that the page may open: the shipped ones, and the system files of one folder."""

from contextlib import suppress
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path

from vvdp.base.errors import ConfigError, Fault, unusable
from vvdp.base.files import write_whole
from vvdp.base.tables import LARGEST_FILE, Table, copy_tables, parsed_table, with_settings
from vvdp.logs.source import FORMATS
from vvdp.systems.circuits import circuit_names
from vvdp.systems.expansion import expand
from vvdp.systems.options import lasting, without_other_position
from vvdp.systems.own_programs import named_code
from vvdp.systems.system import System, built_system, named_systems

MOST_FILES = 200
LARGEST_LOG = 200_000_000
SUFFIX = ".toml"


@dataclass(frozen=True)
class Asked:
    """Request of a page: a system by name, perhaps with another text, other values and another duration."""

    system: str
    text: str | None = None
    settings: tuple[str, ...] = ()
    until: str | None = None


@dataclass(frozen=True)
class Offer:
    """The shipped systems and the files of `folder`; `first` is what the page shows when it opens.

    Of Python and FMUs only `trusted` is run, what the file on the command line names.
    """

    folder: Path
    first: str
    trusted: frozenset[str] = frozenset()

    def names(self) -> dict[str, str]:
        """Name and title of each system: the files of the folder, then the shipped ones."""
        own = sorted(path.name for path in self.folder.glob(f"*{SUFFIX}") if _is_plain(path))[:MOST_FILES]
        return {name: _title(self.text(name), name) for name in (*own, *named_systems())}

    def path(self, name: str) -> Path | None:
        """The file of a system; None of a shipped one. Raises ConfigError for any other name."""
        if name in named_systems():
            return None
        place = self.folder / name
        if Path(name).name != name or not name.endswith(SUFFIX) or "\\" in name or not _is_plain(place):
            raise unusable(name, f"is no system file of {self.folder} (links and files above 1 MB are not opened)")
        return place

    def logs(self) -> list[str]:
        """The measured logs of the folder."""
        found = (path for path in self.folder.iterdir() if path.suffix.lower() in FORMATS)
        return sorted(path.name for path in found if _is_plain(path, LARGEST_LOG))[:MOST_FILES]

    def log(self, name: str) -> Path:
        """The file of a log. Raises ConfigError for any other name."""
        if name not in self.logs():
            raise unusable(name, f"is no log of {self.folder} (links and files above 200 MB are not opened)")
        return self.folder / name

    def text(self, name: str) -> str:
        """The text of a system. Raises ConfigError where it cannot be read."""
        path = self.path(name)
        if path is None:
            return named_systems()[name]
        try:
            return path.read_text("utf-8")
        except (OSError, UnicodeDecodeError) as problem:
            raise unusable(name, f"cannot be read ({problem})") from None

    def text_on_disk(self, name: str) -> str | None:
        """The text of a file as it is now; None of a shipped system, and where it cannot be read."""
        with suppress(ConfigError):
            return None if self.path(name) is None else self.text(name)
        return None

    def system(self, asked: Asked) -> System:
        """The system that a page asks for. Raises ConfigError naming every fault."""
        self.path(asked.system)
        text = self.text(asked.system) if asked.text is None else asked.text
        place = asked.system.removesuffix(SUFFIX)
        kept = _parsed(text, f"{place}{SUFFIX}")
        table = replace(kept, content=copy_tables(kept.content))
        settings = list(asked.settings)
        if settings:
            table = with_settings(without_other_position(table, settings), settings)
        if asked.until is not None:
            table = lasting(table, asked.until, settings)
        self._refuse_foreign_code(table)
        return built_system(table, place, self.folder)

    def save(self, name: str, text: str, before: str) -> None:
        """Writes a file of the folder, if its text is still `before`. Raises ConfigError where it is not."""
        path = self.path(name)
        if path is None:
            raise unusable(name, "is a shipped system; `vvdp new NAME --from SYSTEM` writes a copy that can be changed")
        if self.text(name) != before:
            raise unusable(name, "has changed on the disk since it was opened; open it again")
        parsed_table(text, name)
        write_whole(path, text.encode())

    def _refuse_foreign_code(self, table: Table) -> None:
        """A page may draw circuits; Python is run only if the command line has named the file that names it."""
        for code, kind in named_code(expand(table, self.folder).table.content).items():
            if code not in (*circuit_names(), *self.trusted):
                key = "circuit" if "circuit" in table.content else "programs"
                message = f"{code!r} is {kind}; name the file on the command line to run it: vvdp workbench FILE"
                raise ConfigError([Fault(table.place, table.lines.get(key, 0), key, message)])


def offer_at(path: Path) -> Offer:
    """Offer of a system file, a result directory or a folder. Raises ConfigError if `path` is none of these."""
    if path.is_dir():
        first = "system.toml" if (path / "vvdp.json").is_file() else ""
        offer = Offer(path.resolve(), first)
        return offer if first else Offer(offer.folder, next(iter(offer.names())))
    if path.suffix != SUFFIX or not path.is_file():
        raise unusable(path, "is no system file (TOML), result directory or folder")
    offer = Offer(path.resolve().parent, path.resolve().name)
    table = parsed_table(offer.text(offer.first), path.name)
    with suppress(ConfigError):  # the page shows what is wrong
        table = expand(table, offer.folder).table
    return Offer(offer.folder, offer.first, frozenset(named_code(table.content)))


_parsed = lru_cache(maxsize=8)(parsed_table)
"""The last texts, since values are dragged in the same one."""


def _is_plain(path: Path, most: int = LARGEST_FILE) -> bool:
    """Whether this is a file, no link, of at most so many bytes."""
    return path.is_file() and not path.is_symlink() and path.stat().st_size <= most


def _title(text: str, name: str) -> str:
    try:
        return str(parsed_table(text, name).content.get("title", name))
    except ConfigError:
        return name
