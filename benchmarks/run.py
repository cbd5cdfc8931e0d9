"""Runs the benchmarks named, or all of them, each in a process of its own."""

import subprocess
import sys

NAMES = (
    "real_time",
    "against_c",
    "against_lsoda",
    "start_up",
    "batch",
    "memory",
    "estimators",
    "maps",
    "logs",
    "networks",
)


def main() -> None:
    """One after the other: they would disturb each other."""
    chosen = sys.argv[1:] or NAMES
    failed = []
    for name in chosen:
        print(f"\n== {name}", flush=True)
        if subprocess.run([sys.executable, "-m", f"benchmarks.{name}"], check=False).returncode:
            failed.append(name)
    if failed:
        sys.exit(f"failed: {', '.join(failed)}")


if __name__ == "__main__":
    main()
