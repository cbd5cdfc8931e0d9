"""Peak memory of ten simulated seconds with the default recording, in a new process."""

import tempfile
from statistics import median

from benchmarks.measure import in_new_process, report, run_as_command, spread

PEAK = """
import json
from pathlib import Path
status = Path("/proc/self/status").read_text()
print(json.dumps({{"peak": int(status.partition("VmHWM:")[2].split()[0]) / 1024}}))
"""

ONLY_SIMULATE = """
from vvdp.simulation.run import simulate
from vvdp.systems.system import load_system
system = load_system("prototype", until="10 s")
run = simulate(system.model, system.case, system.stepping)
""" + PEAK.replace("{{", "{").replace("}}", "}")

COMMAND = (
    """
from vvdp.cli.main import main
try:
    main(["run", "prototype", "--until", "10 s", "--out", {folder!r}])
except SystemExit as end:
    assert not end.code, end.code
"""
    + PEAK
)

TARGET = 400.0
ROUNDS = 3


def main(short: bool) -> None:
    """Each in new processes; memory hardly varies. The short form simulates 0.1 s, once, without a report."""
    until, rounds = ("0.1 s", 1) if short else ("10 s", ROUNDS)
    simulates = ONLY_SIMULATE.replace("10 s", until)
    in_new_process(simulates)
    peaks = [in_new_process(simulates)["peak"] for _ in range(rounds)]
    report("simulate, ten seconds", spread(peaks, "MiB"), f"{TARGET:g} MiB", median(peaks) < TARGET)
    if short:
        return
    peaks = []
    for _ in range(ROUNDS):
        with tempfile.TemporaryDirectory() as folder:
            peaks.append(in_new_process(COMMAND.format(folder=f"{folder}/out"))["peak"])
    report("vvdp run with report, ten seconds", spread(peaks, "MiB"), f"{TARGET:g} MiB", median(peaks) < TARGET)


if __name__ == "__main__":
    run_as_command(main)
