"""Objects of a model become a WebAssembly module, with functions of the C library, by the `zig` of the extra `web`."""

import tempfile
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import cache
from importlib import resources
from pathlib import Path

from vvdp.base.extras import require
from vvdp.export.zig import run_zig, zig_path

TRIPLE = "wasm32-unknown-unknown"
TARGET = ("-target", "wasm32-freestanding")
FEATURES = ("bulk-memory", "nontrapping-fptoint", "sign-ext", "mutable-globals")
MOST_STACK = 2**20
MUSL = ("pow_data", "exp_data", "nextafter", "scalbn")
"""Files of the C library that comes with zig."""
OWN = ("erf", "exp", "expm1", "log", "pow", "support", "tanh")


@dataclass(frozen=True)
class Way:
    """How a module calculates `a b + c` with one rounding, which WebAssembly has no instruction for.

    text      LLVM text for it in place of LLVM's own, which calls `fma`
    fused     whether the code needs it at all
    features  what a browser must have besides `FEATURES`
    own       files of the C library's functions
    defined   what they are compiled with
    """

    text: str = ""
    fused: bool = True
    features: tuple[str, ...] = ()
    own: tuple[str, ...] = OWN
    defined: tuple[str, ...] = ()

    @property
    def llvm_features(self) -> str:
        """The features as LLVM names them."""
        return ",".join(f"+{each}" for each in (*FEATURES, *self.features))

    @property
    def machine(self) -> tuple[str, ...]:
        """The machine as zig names it."""
        found = [each.replace("-", "_") for each in (*FEATURES[:-1], *self.features)]
        return (*TARGET, "-mcpu", "+".join(["generic", *found]))


def link(objects: Sequence[bytes], entries: Sequence[str], way: Way) -> bytes:
    """The module of these objects, which exports `entries` and `__heap_base`, behind which memory is free.

    Raises MissingExtraError without the extra `web`, RunError where the linker refuses.
    """
    require("ziglang", "web", "a page that runs a system")
    with tempfile.TemporaryDirectory(prefix="vvdp-web-") as name:
        folder, paths = Path(name), list[str]()
        for number, code in enumerate((*objects, *_library(way))):
            paths.append(f"{number}.o")
            (folder / paths[-1]).write_bytes(code)
        (folder / "math.zig").write_bytes(source("math.zig"))
        command = ["build-exe", "math.zig", *paths, *way.machine, "-O", "ReleaseFast", "-fstrip", "-fno-entry"]
        command += ["--import-memory", "--stack", str(MOST_STACK), "--export=__heap_base"]
        command += [f"--export={each}" for each in entries]
        run_zig(folder, [*command, "-femit-bin=model.wasm"])
        return (folder / "model.wasm").read_bytes()


@cache
def _library(way: Way) -> tuple[bytes, ...]:
    """The objects of the C library's functions."""
    with tempfile.TemporaryDirectory(prefix="vvdp-web-") as name:
        folder = Path(name)
        for file in resources.files("vvdp.web").joinpath("library").iterdir():
            (folder / file.name).write_bytes(file.read_bytes())
        musl = zig_path().parent / "lib" / "libc" / "musl" / "src"
        sources = {each: f"{each}.c" for each in way.own} | {each: str(musl / "math" / f"{each}.c") for each in MUSL}
        flags = [*TARGET, f"-mcpu={way.machine[-1]}", "-nostdlib", "-fno-builtin", "-O2", "-ffp-contract=off", "-w"]
        flags += [*way.defined, "-I.", f"-I{musl / 'math'}", f"-I{musl}"]

        def object_of(name: str) -> bytes:
            run_zig(folder, ["cc", *flags, "-c", sources[name], "-o", f"{name}.o"])
            return (folder / f"{name}.o").read_bytes()

        with ThreadPoolExecutor() as threads:
            return tuple(threads.map(object_of, sources))


def source(name: str) -> bytes:
    """A file of what is linked to a model."""
    return resources.files("vvdp.web").joinpath("library", name).read_bytes()


SOFTWARE = Way(own=(*OWN, "fma", "whole_fma"))
"""By sums and products, with the same bits."""
RELAXED = Way(text=source("fma.ll").decode(), features=("simd128", "relaxed-simd"))
"""By an instruction that a browser may carry out with one rounding or with two: a page tries it first."""
SPLIT = Way(fused=False, defined=("-DSPLIT",))
"""By products that are split where it matters: the last digits differ."""
