"""The loops that are compiled once for each installation: whether they are, and code of an earlier text taken away."""

import hashlib
from collections.abc import Callable
from functools import cache
from pathlib import Path

LOOP = (
    *("landing", "lane_code", "lane_loop", "lane_vectors", "loop", "marks", "pace", "places", "queue", "schedule"),
    *("steps", "stiff"),
)
"""The modules that the compiled loops are written in."""
ALONE, SIDE_BY_SIDE = "loop.run", "lane_loop.run_lanes"
"""The functions for one case, and for many at once; the second takes twice as long to compile as the first."""
SECONDS = 30.0
"""About how long the loop for one case takes to compile, on an idle machine of 2024."""
WORDS = {
    ALONE: "the simulation loop (once for each installation): about half a minute",
    SIDE_BY_SIDE: "the loop for many cases at once (once for each installation): about a minute",
}
FOLDER = Path(__file__).parent


def is_loop_compiled(loop: str = ALONE) -> bool:
    """Whether a compiled loop is kept from an earlier run."""
    _drop_stale_loops()
    return any((FOLDER / "__pycache__").glob(f"{loop}-*.nbi"))


def announce(loop: str, say: Callable[[str], None]) -> None:
    """Says that a loop must be compiled, where that is so."""
    if not is_loop_compiled(loop):
        say(f"compiling {WORDS[loop]}")


@cache
def _drop_stale_loops() -> None:
    """Numba knows a change of a function's own file only; the loops are written in several."""
    texts = (*(FOLDER / f"{stem}.py" for stem in LOOP), FOLDER.parent / "numerics" / "tableaus.py")
    digest = hashlib.sha256(b"".join(text.read_bytes() for text in texts)).hexdigest()
    kept = FOLDER / "__pycache__" / "loop.digest"
    try:
        if kept.exists() and kept.read_text() == digest:
            return
        for stem in LOOP:
            for old in kept.parent.glob(f"{stem}.*.nb[ic]"):
                old.unlink(missing_ok=True)
        kept.parent.mkdir(exist_ok=True)
        kept.write_text(digest)
    except OSError:
        return  # a folder that cannot be written holds nothing of an earlier version
