"""A system as its page has it, carried out in Node, beside its run on the command line."""

import json
import subprocess
from collections.abc import Mapping
from importlib import resources
from pathlib import Path
from typing import Any

import numpy as np
from tests.conftest import required_program

from vvdp.base.arrays import Array
from vvdp.simulation.run import Run


class InNode:
    """A model of a page in Node.

    relaxed  whether Node has the instruction of the module `fused`
    """

    def __init__(self, model: Mapping[str, Any], folder: Path, *, relaxed: bool = False) -> None:
        self.folder, self.flags = folder, ["--experimental-wasm-relaxed-simd"] if relaxed else []
        (folder / "model.json").write_text(json.dumps(model), "utf-8")

    def ask(self, what: str, values: Mapping[str, Any] | None = None, level: str = "exact") -> Any:
        """What the script of the tests answers."""
        scripts = str(resources.files("vvdp.web") / "assets")
        job = json.dumps({"what": what, "values": values or {}, "level": level})
        command = [required_program("node"), *self.flags, str(Path(__file__).with_name("run.mjs")), scripts]
        command += [str(self.folder / "model.json"), job, str(self.folder / "rows.bin")]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stderr
        return json.loads(done.stdout)

    def rows(self, values: Mapping[str, Any] | None = None, level: str = "exact") -> dict[str, Array]:
        """All that a run leaves in memory, by the names of the loop."""
        told = self.ask("rows", values, level)
        assert told["answer"] == 0
        content, found, at = (self.folder / "rows.bin").read_bytes(), {}, 0
        for name, size in told["bytes"].items():
            found[name] = np.frombuffer(content[at : at + size])
            at += size
        return found


def left_by(run: Run) -> dict[str, Array]:
    """The same from a run of the command line."""
    reached = run.reached
    found = {
        "y": run.final, "command": reached.command, "memory": reached.memory, "agenda": reached.agenda,
        "clock": reached.clock, "record_times": run.times, "record": run.states, "record_command": run.commands,
        "record_memory": run.memories, "mark_times": run.mark_times, "mark_states": run.mark_states,
        "span_times": run.span_times, "span_states": run.span_states, "low": run.low, "high": run.high,
    }  # fmt: skip
    return {name: np.ravel(values) for name, values in found.items()}


def differing(one: Mapping[str, Array], other: Mapping[str, Array]) -> dict[str, int]:
    """How many numbers of each array differ in a bit; all of them where one has other rows."""
    found = {}
    for name, values in other.items():
        same = one[name].size == values.size
        count = int((one[name].view(np.int64) != values.view(np.int64)).sum()) if same else max(values.size, 1)
        found |= {name: count} if count else {}
    return found
