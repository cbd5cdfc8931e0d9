"""The index of a study in the midst of a transaction: it is alone, and what is broken off counts for nothing."""

import os
import subprocess
import sys
from pathlib import Path

from vvdp.studies.index import Row, Stamp, read_index, write_index

BEFORE = {"one": (Stamp(1, 1), [Row("a", None, "{}", "{}")])}
AFTER = {"two": (Stamp(2, 2), [Row("b", None, "{}", "{}")])}
KILLED = """
import os, pathlib, signal
from vvdp.studies.index import NAME, _open_index
place = pathlib.Path.cwd() / NAME
with _open_index(place) as base:
    base.execute("delete from files")
    print(os.listdir(), flush=True)
    os.kill(os.getpid(), signal.SIGKILL)
"""


def test_a_killed_transaction_leaves_nothing_and_is_not_read(tmp_path: Path) -> None:
    write_index(tmp_path, BEFORE)
    assert read_index(tmp_path) == BEFORE
    path = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}
    told = subprocess.run([sys.executable, "-c", KILLED], cwd=tmp_path, env=path, capture_output=True, text=True)
    assert told.stdout.strip() == "['index.sqlite']", told.stderr
    assert [each.name for each in tmp_path.iterdir()] == ["index.sqlite"]
    assert read_index(tmp_path) == {}
    write_index(tmp_path, AFTER)
    assert read_index(tmp_path) == AFTER
    assert [each.name for each in tmp_path.iterdir()] == ["index.sqlite"]
