"""The compiler and linker that comes with the package ziglang, in a process of its own."""

import os
import subprocess
from collections.abc import Sequence
from importlib.util import find_spec
from pathlib import Path

from vvdp.base.errors import RunError
from vvdp.simulation.cache import default_cache


def run_zig(folder: Path, words: Sequence[str]) -> None:
    """Runs zig in a folder. Raises RunError with its last words where it fails."""
    kept = str(default_cache() / "zig")
    known = {**os.environ, "ZIG_GLOBAL_CACHE_DIR": kept, "ZIG_LOCAL_CACHE_DIR": str(folder / "local")}
    done = subprocess.run([zig_path(), *words], cwd=folder, env=known, capture_output=True, text=True, check=False)
    if done.returncode:
        raise RunError(f"zig {words[0]} failed: {done.stderr.strip()[-600:]}")


def has_zig() -> bool:
    """Whether the package is installed."""
    return find_spec("ziglang") is not None


def zig_path() -> Path:
    """The program of the package."""
    found = find_spec("ziglang")
    assert found is not None and found.origin is not None
    return Path(found.origin).parent / ("zig.exe" if os.name == "nt" else "zig")
