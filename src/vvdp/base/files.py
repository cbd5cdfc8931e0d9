"""Files that are whole or absent: written under another name, synced, renamed."""

import os
import secrets
from pathlib import Path


def write_whole(path: Path, content: str | bytes) -> None:
    """Writes a file that is never seen in part, and is on the disk when this returns.

    Raises OSError where it cannot be written; nothing of it is left then.
    """
    temporary = path.with_name(f".{path.name}.{secrets.token_hex(8)}.tmp")  # unlike that of any other machine
    try:
        with temporary.open("wb") as file:
            file.write(content.encode() if isinstance(content, str) else content)
            file.flush()
            os.fsync(file.fileno())
        temporary.replace(path)
    except BaseException:
        temporary.unlink(missing_ok=True)
        raise
    sync_folder(path.parent)


def sync_folder(folder: Path) -> None:
    """Returns when the names in `folder` are on the disk."""
    opened = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(opened)
    finally:
        os.close(opened)
