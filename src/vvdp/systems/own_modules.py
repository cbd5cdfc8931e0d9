"""Modules of a user's own that draw circuits: which one drew a system, and whether a saved system may run it again.

A result directory is data, and says which module drew its circuit: name, place, SHA-256. It may come from anyone, so
this alone lets nothing run. A module is run again where this installation has run it before, from the same place with
the same content, of which it keeps a note in its cache; or where the user names it (`--trust`).
"""

import hashlib
import importlib.util
import linecache
import re
import sys
import types
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from vvdp.base.errors import ConfigError, Fault, ParameterError, RunError
from vvdp.base.manifest import has_list
from vvdp.simulation.cache import check_private, default_cache

MODULE_NAME = re.compile(r"[^\W\d]\w*(\.[^\W\d]\w*)*")


class UntrustedModuleError(ConfigError):
    """A saved system needs a module that is not run without being asked for."""


@dataclass(frozen=True)
class OwnModule:
    """A module as it was when it was run."""

    name: str
    path: Path
    sha256: str

    @property
    def flat(self) -> dict[str, str]:
        """As meta.json keeps it."""
        return {"name": self.name, "path": str(self.path), "sha256": self.sha256}


def module_name(circuit: str) -> str:
    """The module in "module:function". Raises ParameterError where that is no dotted name, such as a path."""
    name = circuit.partition(":")[0]
    if not MODULE_NAME.fullmatch(name):
        raise ParameterError(f"{name!r} is not the name of a module; expected identifiers with dots, not a path")
    return name


def local_file(name: str, folder: Path) -> Path | None:
    """The file of a module in `folder`; None where it is not there."""
    path = folder / f"{name.replace('.', '/')}.py"
    return path if path.is_file() else None


def run_local_module(name: str, path: Path) -> types.ModuleType:
    """The module in the file `path`, run. Raises ParameterError where it cannot be, or lies in a result directory."""
    if any(has_list(folder) for folder in path.resolve().parents):
        raise ParameterError(
            f"{path} lies in a result directory, and nothing in one is run; copy it and the system file elsewhere"
        )
    _announce(path)
    spec = importlib.util.spec_from_file_location(name, path)
    assert spec and spec.loader
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module
    linecache.checkcache(str(path))  # whatever reads the text of its functions reads what is run here
    try:
        spec.loader.exec_module(module)
    except Exception as problem:
        del sys.modules[name]
        raise ParameterError(f"{path} cannot be run: {type(problem).__name__}: {problem}") from problem
    return module


def own_module(circuit: str, folder: Path) -> OwnModule | None:
    """The module that a system in `folder` names and that has been run; None where it names none."""
    if ":" not in circuit:
        return None
    name = module_name(circuit)
    file = local_file(name, folder) or getattr(sys.modules.get(name), "__file__", None)
    if file is None:
        return None
    path = Path(file).resolve()
    return OwnModule(name, path, hashlib.sha256(path.read_bytes()).hexdigest())


def folder_of_saved(circuit: Any, place: str, recorded: Any, trust: str) -> Path:
    """The folder in which the module of a saved system is looked for: none of its own.

    circuit   what the system names as its circuit
    place     what the system is called in messages
    recorded  the module at the run, as meta.json has it
    trust     a module that the user lets run: its name, or its file
    Raises UntrustedModuleError where there is a module to run, and neither is it known here nor does the user say so.
    """
    if not isinstance(circuit, str) or ":" not in circuit:
        return Path()
    try:
        name = module_name(circuit)
    except ParameterError as problem:
        raise ConfigError([Fault(place, 0, "circuit", str(problem))]) from None
    module = _recorded_module(recorded, name)
    if trust and (path := _trusted_file(trust, name, module)) is not None:
        return path.parents[name.count(".")]
    if module is not None and module.path.is_file():
        reason, file = _doubt(module), name
    else:
        reason, file = "where it was is not recorded" if module is None else f"{module.path} is not there", f"{name}.py"
    if module is None or reason:
        words = f"needs the code of {name}, which is not run ({reason}); look at it, and let it run by --trust {file}"
        raise UntrustedModuleError([Fault(place, 0, "circuit", words)])
    return module.path.parents[name.count(".")]


def _recorded_module(recorded: Any, name: str) -> OwnModule | None:
    """Module `name` as recorded in meta.json; None if there is none, or no such file could be."""
    if not isinstance(recorded, Mapping) or recorded.get("name") != name:
        return None
    path, digest = recorded.get("path"), recorded.get("sha256")
    if not isinstance(path, str) or not isinstance(digest, str):
        return None
    found = Path(path)
    fits = found.is_absolute() and found.as_posix().endswith(f"/{name.replace('.', '/')}.py")
    return OwnModule(name, found, digest) if fits else None


def _trusted_file(trust: str, name: str, module: OwnModule | None) -> Path | None:
    """The file of the module that the user lets run; None where that is another one, or is not there."""
    if trust == name:
        return module.path if module is not None and module.path.is_file() else None
    path = Path(trust).resolve()
    fits = path.is_file() and path.as_posix().endswith(f"/{name.replace('.', '/')}.py")
    return path if fits else None


def _doubt(module: OwnModule) -> str:
    """Why a module is not run without being asked for; empty where it is as this installation ran it before."""
    content = module.path.read_bytes()
    if hashlib.sha256(content).hexdigest() != module.sha256:
        return f"{module.path} has changed since the run"
    marker = _marker(module.path, content)
    with suppress(OSError, RunError):
        check_private(default_cache())
        check_private(marker.parent)
        return "" if marker.is_file() else f"{module.path} was never run here"
    return f"nothing in {default_cache()} can say that {module.path} was run here"


def _announce(path: Path) -> None:
    """Says once for each module and content, on stderr, that a system file makes it run, and notes that it was run."""
    with suppress(OSError):  # said again next time
        content = path.read_bytes()
        marker = _marker(path, content)
        if marker.exists():
            return
        print(f"{path}: code of your own, which the system file names, is executed (said once)", file=sys.stderr)
        marker.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
        marker.write_text(f"{path.resolve()}\n", encoding="utf-8")


def _marker(path: Path, content: bytes) -> Path:
    """The note that a module with this content was run from this place."""
    known = hashlib.sha256(hashlib.sha256(content).digest() + str(path.resolve()).encode(errors="surrogateescape"))
    return default_cache() / "modules" / known.hexdigest()[:32]
