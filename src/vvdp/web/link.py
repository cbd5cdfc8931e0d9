"""Objects of a model become a WebAssembly module, with functions of the C library, by the `zig` of the extra `web`."""

import tempfile
from collections.abc import Sequence
from functools import cache
from importlib import resources
from pathlib import Path

from vvdp.base.extras import require
from vvdp.export.zig import run_zig, zig_path

TRIPLE = "wasm32-unknown-unknown"
FEATURES = "+bulk-memory,+nontrapping-fptoint,+sign-ext,+mutable-globals"
MACHINE = ("-target", "wasm32-freestanding", "-mcpu", "generic+bulk_memory+nontrapping_fptoint+sign_ext")
MUSL = ("pow_data", "exp_data", "nextafter", "fma", "scalbn")
"""Files of the C library that comes with zig."""
OWN = ("erf", "exp", "expm1", "fma", "log", "pow", "support", "tanh")
MOST_STACK = 2**20


def link(objects: Sequence[bytes], entries: Sequence[str]) -> bytes:
    """The module of these objects, which exports `entries` and `__heap_base`, behind which memory is free.

    Raises MissingExtraError without the extra `web`, RunError where the linker refuses.
    """
    require("ziglang", "web", "a page that runs a system")
    with tempfile.TemporaryDirectory(prefix="vvdp-web-") as name:
        folder, paths = Path(name), list[str]()
        for number, code in enumerate((*objects, *_library())):
            paths.append(f"{number}.o")
            (folder / paths[-1]).write_bytes(code)
        (folder / "math.zig").write_bytes(_source("math.zig"))
        command = ["build-exe", "math.zig", *paths, *MACHINE, "-O", "ReleaseFast", "-fstrip", "-fno-entry"]
        command += ["--import-memory", "--stack", str(MOST_STACK), "--export=__heap_base"]
        command += [f"--export={each}" for each in entries]
        run_zig(folder, [*command, "-femit-bin=model.wasm"])
        return (folder / "model.wasm").read_bytes()


@cache
def _library() -> tuple[bytes, ...]:
    """The objects of the C library's functions."""
    with tempfile.TemporaryDirectory(prefix="vvdp-web-") as name:
        folder = Path(name)
        for file in resources.files("vvdp.web").joinpath("library").iterdir():
            (folder / file.name).write_bytes(file.read_bytes())
        musl = zig_path().parent / "lib" / "libc" / "musl" / "src" / "math"
        sources = [*(folder / f"{each}.c" for each in OWN), *(musl / f"{each}.c" for each in MUSL)]
        flags = ["-target", MACHINE[1], f"-mcpu={MACHINE[3]}", "-nostdlib", "-fno-builtin", "-O2", "-ffp-contract=off"]
        found = []
        for source in sources:
            own = ["-Dfma=in_whole_numbers"] if source == musl / "fma.c" else []
            run_zig(folder, ["cc", *flags, *own, "-w", "-I.", f"-I{musl}", "-c", str(source), "-o", "one.o"])
            found.append((folder / "one.o").read_bytes())
        return tuple(found)


def _source(name: str) -> bytes:
    return resources.files("vvdp.web").joinpath("library", name).read_bytes()
