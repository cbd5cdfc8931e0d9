"""An FMU as one file: description, sources, binaries, and a page about it."""

import hashlib
import html
import io
import zipfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from importlib.metadata import version
from typing import Any

from vvdp.base.errors import ConfigError, Fault
from vvdp.base.kinds import Kind
from vvdp.export.fmu_binary import compile_binary
from vvdp.export.fmu_description import CS, ME, build_description, description, fmu_name
from vvdp.export.fmu_extras import NOTHING, Extras, extra_files
from vvdp.export.fmu_model import FmuModel
from vvdp.export.fmu_sources import TOKEN_SIZE, source_files
from vvdp.export.fmu_units import unit_name
from vvdp.programs.foreign.platforms import Platform, this_platform

KINDS = {"cs": (CS,), "me": (ME,), "both": (ME, CS)}
"""Kinds of FMU: co-simulation with the loop of vvdp, model exchange for the integrator of a host, or both."""
WHEN = (1980, 1, 1, 0, 0, 0)
"""The time of each entry: the same text gives the same file."""


@dataclass(frozen=True)
class Fmu:
    """An FMU: its content, and that of its entries by name."""

    model: FmuModel
    fmi: int
    kind: str
    content: bytes
    entries: Mapping[str, bytes]
    compiler: str

    @property
    def facts(self) -> dict[str, Any]:
        """Summary of an export, as the command line prints it."""
        model, machine = self.model, self.model.machine
        binaries = {name: each for name, each in self.entries.items() if name.startswith("binaries/")}
        return {
            "verb": "export fmu",
            "system": model.system.name,
            "fmi": self.fmi,
            "kind": self.kind,
            "files": sorted(self.entries),
            "functions": len(machine.functions),
            "lines": sum(each.count(b"\n") for name, each in self.entries.items() if name.endswith(".c")),
            "states": machine.begun.state.size,
            "event_indicators": sum(each.vector == "indicator" for each in model.inner),
            "memory_bytes": machine.size,
            "inputs": model.inputs,
            "outputs": [each.name for each in model.outputs],
            "free_parameters": [each.name for each in model.settables if each.name not in model.inputs],
            "fixed_parameters": [{"key": key, "reason": why} for key, why in model.fixed],
            "compiler": self.compiler,
            "bytes": len(self.content),
            "platforms": [name.split("/")[1] for name in binaries],
            "binary_bytes": sum(map(len, binaries.values())),
            "hash": machine.hash,
        }


def require_kind(kind: str) -> None:
    """Raises ConfigError for a kind of FMU that does not exist."""
    if kind not in KINDS:
        raise ConfigError([Fault("--kind", 0, kind, f"unknown; expected {', '.join(KINDS)}")])


def fmu(
    model: FmuModel, fmi: int, platforms: Sequence[Platform] = (), extras: Extras = NOTHING, *, is_solved: bool = True
) -> Fmu:
    """The FMU of a model for FMI 2 or 3, with a binary for each platform (this machine where none is given).

    If the model is a guest, it is for model exchange, and for co-simulation as well where `is_solved`. `extras`
    are for people and tools. Without a compiler it has sources only, and `compiler` is empty.

    Raises RunError where the compiler refuses.
    """
    if fmi not in (2, 3):
        raise ConfigError([Fault("--fmi", 0, str(fmi), "expected 2 or 3")])
    name, flags = fmu_name(model), model.machine.flags
    kind = "cs" if not model.machine.is_guest else "both" if is_solved else "me"
    token = f"{{{_hash_of(model, fmi)}}}"
    sources = source_files(model, fmi, token)
    files = {
        "modelDescription.xml": description(model, fmi, token, list(sources), KINDS[kind]),
        "documentation/index.html": page(model, flags, extras.diagram),
        "documentation/licenses/license.txt": LICENCES,
        **{f"sources/{each}": text for each, text in sources.items()},
    }
    if fmi == 3:
        files["sources/buildDescription.xml"] = build_description(model, list(sources), flags)
    entries = {each: text.encode() for each, text in files.items()}
    entries |= extra_files(model, fmi, extras)
    compilers = []
    for each in platforms or (this_platform(),):
        compiler, binary = compile_binary(sources, flags, each)
        if binary:
            entries[f"binaries/{each.folder(fmi)}/{name}{each.end}"] = binary
            compilers.append(compiler)
    return Fmu(
        model=model,
        fmi=fmi,
        kind=kind,
        content=_zip_of(entries),
        entries=entries,
        compiler=", ".join(dict.fromkeys(compilers)),
    )


def _hash_of(model: FmuModel, fmi: int) -> str:
    """The identity of an FMU: its version, text and variables; numbers of the system included."""
    texts = source_files(model, fmi, "")
    names = [each.name for each in model.variables]
    words = "\n".join([version("vvdp"), *texts.values(), *names])
    return hashlib.sha256(words.encode()).hexdigest()[: TOKEN_SIZE - 8]


def _zip_of(entries: Mapping[str, bytes]) -> bytes:
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w") as file:
        for name, content in entries.items():
            file.writestr(zipfile.ZipInfo(name, WHEN), content, zipfile.ZIP_DEFLATED, 9)
    return buffer.getvalue()


LICENCES = """\
The sources and the binary were written by vvdp (Apache-2.0). The headers fmi2*.h and fmi3*.h are those of the Modelica
Association Project FMI under the 2-Clause BSD License, which stands in each of them.
"""


def page(model: FmuModel, flags: Sequence[str], diagram: str = "") -> str:
    """The page of an FMU: its circuit, its variables, what is fixed and why, and how to compile it."""
    system = model.system
    rows = [_row(each.name, each.role, each.kind, f"{each.low:g} to {each.high:g}") for each in model.settables]
    shown = [_row(each.name, "output", each.kind, each.vector) for each in model.outputs]
    fixed = [f"<tr><td>{html.escape(key)}</td><td>{html.escape(why)}</td></tr>" for key, why in model.fixed]
    head = "<tr><th>variable</th><th>role</th><th>unit</th><th>range or vector</th></tr>"
    return "\n".join(
        [
            f'<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8"><title>{html.escape(system.name)}</title>',
            f"</head><body><h1>{html.escape(system.name)}</h1>",
            f"<p>Written by vvdp {version('vvdp')}. Circuit, programs and simulation loop are those of vvdp;",
            f"hash of the text: {model.machine.hash}.",
            f"Conditions are calculated every {system.stepping.sample_period:g} s,",
            f"the tolerance is {system.stepping.relative_tolerance:g}. Units are SI; pressures are absolute.</p>",
            diagram,
            f"<p>Compile the sources with: {html.escape(' '.join(flags))}</p>",
            f"<h2>Variables</h2><table>{head}{''.join([*rows, *shown])}</table>",
            f"<h2>Fixed values</h2><table><tr><th>value</th><th>reason</th></tr>{''.join(fixed)}</table>",
            "</body></html>\n",
        ]
    )


def _row(name: str, role: str, kind: Kind | None, words: str) -> str:
    cells = (name, role, unit_name(kind) or "1", words)
    return f"<tr>{''.join(f'<td>{html.escape(cell)}</td>' for cell in cells)}</tr>"
