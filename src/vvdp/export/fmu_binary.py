"""The binaries of an FMU: by a C compiler of this machine, and for other machines by that of the package ziglang."""

import os
import shutil
import subprocess
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path

from vvdp.base.errors import ConfigError, Fault, RunError
from vvdp.export.zig import has_zig, run_zig
from vvdp.programs.foreign.platforms import DARWIN, LINUX, WINDOWS, Platform, this_platform

PLATFORMS = tuple(
    Platform(*pair)
    for pair in (
        ("x86_64", LINUX),
        ("aarch64", LINUX),
        ("x86_64", WINDOWS),
        ("x86_64", DARWIN),
        ("aarch64", DARWIN),
    )
)
"""For which a binary can be made from any machine."""
TARGETS = {LINUX: "linux-gnu.2.17", WINDOWS: "windows-gnu", DARWIN: "macos"}
"""Names of the systems for the compiler; the C library of Linux is that of 2012, so that any later one will do."""


SMALL = ("-fvisibility=hidden", "-fno-asynchronous-unwind-tables")
"""C has no exceptions, so that nothing needs tables for them."""
CORE = "_core.c"
"""How the file ends that takes the time of a run; the others are compiled to be small."""
PACKED = ("-Wl,-z,noseparate-code",)
"""Lets code and constants share pages of memory, so that the file has no gaps; the linker of zig does not know it."""


def platforms_named(names: Sequence[str], fmi: int) -> tuple[Platform, ...]:
    """The platforms of an FMU, this machine where none is named.

    Raises ConfigError for one that is not known, for two that share a folder, and where their compiler is missing.
    """
    if not names:
        return (this_platform(),)
    known = {str(each): each for each in (*PLATFORMS, this_platform())}
    for name in names:
        if name not in known:
            raise ConfigError([Fault("--platform", 0, name, f"unknown; expected one of {', '.join(known)}")])
    chosen = tuple(dict.fromkeys(known[name] for name in names))
    folders = [each.folder(fmi) for each in chosen]
    if len(set(folders)) < len(folders):
        why = "FMI 2 has one folder for all processors of a system: choose one of them, or --fmi 3"
        raise ConfigError([Fault("--platform", 0, " ".join(names), why)])
    if not has_zig() and any(each != this_platform() for each in chosen):
        why = "binaries for other machines need the package ziglang: pip install 'vvdp[fmi-cross]'"
        raise ConfigError([Fault("--platform", 0, " ".join(names), why)])
    return chosen


def compile_binary(sources: Mapping[str, str], flags: Sequence[str], target: Platform) -> tuple[str, bytes]:
    """The compiler that was used and the library that it made; both empty where there is no compiler.

    For this machine a C compiler that is found (CC, gcc, cc, clang), else that of the package ziglang.
    """
    candidates = filter(None, (os.environ.get("CC"), "gcc", "cc", "clang"))
    found = next(filter(None, map(shutil.which, candidates)), None) if target == this_platform() else None
    if found is None and not has_zig():
        return "", b""
    with tempfile.TemporaryDirectory(prefix="vvdp-fmu-") as name:
        folder = Path(name)
        for each, text in sources.items():
            (folder / each).write_text(text, "utf-8")
        others = [each for each in sources if each.endswith(".c") and not each.endswith(CORE)]
        core = next(each for each in sources if each.endswith(CORE))
        packed = PACKED if found and target.system == LINUX else ()
        whole = ["-shared", "-s", *packed, "-o", "fmu.bin", "core.o", *others, "-lm"]
        for words in (["-O2", "-c", "-o", "core.o", core], ["-Os", *whole]):
            _compile(folder, [*flags, *SMALL, "-fPIC", *words], found, target)
        return Path(found).name if found else "ziglang", (folder / "fmu.bin").read_bytes()


def _compile(folder: Path, words: Sequence[str], found: str | None, target: Platform) -> None:
    """Runs a compiler in a folder, that of ziglang if none was found."""
    if found is None:
        run_zig(folder, ["cc", "-target", f"{target.processor}-{TARGETS[target.system]}", *words])
        return
    done = subprocess.run([found, *words], cwd=folder, capture_output=True, text=True, check=False)
    if done.returncode:
        raise RunError(f"{found} failed: {done.stderr.strip()[-600:]}")
