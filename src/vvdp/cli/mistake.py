"""The report on an error that vvdp did not expect: one file with all that is needed to find the cause."""

import os
import platform
import sys
import tempfile
import time
import traceback
from pathlib import Path


def report_mistake(problem: BaseException) -> str:
    """Write the full report on `problem` into a file; return the line for the user."""
    from vvdp.base.version import VERSION

    at = traceback.extract_tb(problem.__traceback__)[-1]
    what = " ".join(f"{type(problem).__name__}: {problem}".split())[:300]
    text = "\n".join(
        [
            f"vvdp {VERSION}, Python {platform.python_version()}, {platform.platform()}",
            f"written {time.strftime('%Y-%m-%dT%H:%M:%S%z')}",
            f"command: {sys.argv}",
            "",
            *traceback.format_exception(problem),
        ]
    )
    place = _keep(text)
    kept = f"the full report is in {place}; please send it with" if place else "please add the command to"
    return (
        f"vvdp: unexpected error, a mistake of vvdp: {what} ({at.filename}:{at.lineno}); {kept} an issue to the project"
    )


def _keep(text: str) -> Path | None:
    """The file that holds the text: in the cache of vvdp, else in the folder for temporary files; None without both."""
    from vvdp.simulation.cache import default_cache

    name = f"error-{time.strftime('%Y%m%d-%H%M%S')}-{os.getpid()}.txt"
    for folder in (default_cache() / "errors", Path(tempfile.gettempdir())):
        try:
            folder.mkdir(mode=0o700, parents=True, exist_ok=True)
            with (folder / name).open("x", encoding="utf-8", errors="backslashreplace") as file:
                file.write(text)
        except OSError:
            continue
        return folder / name
    return None
