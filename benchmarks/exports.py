"""Processor time of the export of an FMU: the systems named, or all that are shipped.

python -m benchmarks.exports [NAME ...]
"""

import resource
import sys
import time

from vvdp.export import fmu_model
from vvdp.export.fmu import fmu
from vvdp.systems.changeable import changeable_values
from vvdp.systems.system import load_system, shipped_systems


def spent(who: int) -> float:
    """Processor time of this process or of its children [s]."""
    used = resource.getrusage(who)
    return used.ru_utime + used.ru_stime


def main() -> None:
    """Prints a line per system: whether its values are free, then its export without and with the compiler."""
    print(f"{'system':32s}{'values [s]':>12s}{'export [s]':>12s}{'compiler [s]':>14s}")
    for name in sys.argv[1:] or shipped_systems():
        began = time.process_time()
        changeable_values(load_system(name), lambda system: system.circuit.text)
        values = time.process_time() - began
        before = [spent(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
        fmu(fmu_model.fmu_model(load_system(name)), 3)
        own, compiler = (
            spent(who) - was for who, was in zip((resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN), before, strict=True)
        )
        print(f"{name:32s}{values:12.2f}{own:12.2f}{compiler:14.2f}", flush=True)


if __name__ == "__main__":
    main()
