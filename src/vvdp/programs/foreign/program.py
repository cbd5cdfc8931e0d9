"""A foreign FMU as a program of a circuit."""

import hashlib
import json
import tempfile
from collections.abc import Mapping, Sequence
from functools import cache, partial
from pathlib import Path
from typing import Any

import numpy as np

from vvdp.base.errors import ParameterError
from vvdp.network.program import ProgramType
from vvdp.programs.foreign.archive import Archive, open_archive
from vvdp.programs.foreign.description import INPUT, OUTPUT, Description
from vvdp.programs.foreign.instance import Plan
from vvdp.programs.foreign.partners import Foreign, register, release, slot_of
from vvdp.programs.foreign.report import ExchangeReport
from vvdp.programs.foreign.step import StepText
from vvdp.programs.foreign.table import FieldError, joints, named_entries, parameter, power_pairs, switch
from vvdp.simulation.exchange import Partner


def foreign_program(name: str, path: Path, table: Mapping[str, object]) -> ProgramType:
    """The program that the FMU in a file makes with the keys `KEYS` of its table; nothing of it is run.

    Raises FieldError with the key and its fault.
    """
    try:
        archive, digest = open_known(path)
    except ParameterError as problem:
        raise FieldError("fmu", f"{path.name}: {problem}") from None
    _refuse_unusable(archive, path)
    read, given = (joints(archive, table, key, of) for key, of in (("inputs", INPUT), ("outputs", OUTPUT)))
    text = StepText(read, given, power_pairs(table, read, given), extrapolates=switch(table, "extrapolate"))
    parameters = [parameter(archive, key, entry) for key, entry in named_entries(table, "values").items()]
    references = [[joint.variable.reference for joint in each] for each in (read, given)]
    words = json.dumps([name, digest, references, parameters, text.source(0.0)])
    key = float(int(hashlib.sha256(words.encode()).hexdigest()[:13], 16))
    plan = partial(_plan, archive.description, (path, digest), references, parameters)
    register(key, Foreign(name, path, plan, archive.description.has("canBeInstantiatedOnlyOncePerProcess")))
    step, start = text.functions(name, key)
    return ProgramType(
        step=step,
        reading=text.reading,
        command=text.first_command,
        start=start,
        report=ExchangeReport if text.power else None,
        partner=Partner(_is_begun, _trouble, _release),
        ramps=frozenset(joint.name for joint in text.outputs if text.extrapolates),
    )


@cache
def _open(path: Path, stamp: tuple[int, int]) -> tuple[Archive, str]:
    return open_archive(path), hashlib.sha256(path.read_bytes()).hexdigest()


def open_known(path: Path) -> tuple[Archive, str]:
    """The FMU in a file, and the hash of the file. Raises ParameterError if it cannot be used."""
    try:
        found = path.stat()
    except OSError as problem:
        raise ParameterError(f"cannot be read ({problem.strerror})") from None
    return _open(path, (found.st_mtime_ns, found.st_size))


def _refuse_unusable(archive: Archive, path: Path) -> None:
    """Raises FieldError for an FMU that cannot be stepped here."""
    known = archive.description
    if "CoSimulation" not in known.kinds:
        kinds = ", ".join(known.kinds) or "nothing"
        raise FieldError("fmu", f"{path.name}: the FMU offers {kinds}; expected CoSimulation")
    if known.has("needsExecutionTool"):
        raise FieldError("fmu", f"{path.name}: the FMU runs only with its tool ({known.tool or 'not named'})")
    try:
        _ = archive.binary
    except ParameterError as problem:
        raise FieldError("fmu", f"{path.name}: {problem}") from None


def _plan(
    known: Description,
    file: tuple[Path, str],
    references: Sequence[Sequence[int]],
    parameters: Sequence[tuple[int, float]],
) -> Plan:
    """Data for the calls of the FMU in a file with a hash; unpacks it. Raises ParameterError."""
    folder, binary = _unpack(*file)
    return Plan(
        fmi=known.fmi,
        binary=str(binary),
        resources=str(folder / "resources"),
        identifier=known.identifier,
        token=known.token,
        inputs=references[0],
        outputs=references[1],
        parameters=[reference for reference, _ in parameters],
        values=[value for _, value in parameters],
    )


_folders: list[tempfile.TemporaryDirectory[str]] = []
"""Folders in which FMUs are unpacked, until the process ends."""


@cache
def _unpack(path: Path, digest: str) -> tuple[Path, Path]:
    """The folder in which an FMU was unpacked, and its binary there. Raises ParameterError if the file is another."""
    archive, now = open_known(path)
    if now != digest:
        raise ParameterError("the file has changed since the system was read")
    _folders.append(tempfile.TemporaryDirectory(prefix="vvdp-fmu-", ignore_cleanup_errors=True))
    folder = Path(_folders[-1].name)
    return folder, archive.unpack(folder)


def _is_begun(memory: Any) -> bool:
    return bool(memory.handle)


def _trouble(memory: Any) -> str:
    slot = slot_of(memory.handle)
    if slot is None:
        return ""
    given = {name.removeprefix("gave_"): value for name, value in memory._asdict().items() if name.startswith("gave_")}
    odd = [name for name, value in given.items() if not np.isfinite(value)]
    return slot.why() or (slot.sentence(memory.time, f"it gave no finite {odd[0]}") if odd else "")


def _release(memory: Any) -> None:
    release(memory.handle)
