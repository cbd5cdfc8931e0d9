"""Writes the tables of docs/c-export.md on the shipped programs as C. `python docs/site/exported_programs.py`

The second table needs `arm-none-eabi-gcc` and `qemu-system-arm`; without them it stays as it is.
"""

from collections.abc import Iterator
from pathlib import Path

from vvdp.base.errors import RunError
from vvdp.export.c_folder import c_files, c_part, facade_text, facts
from vvdp.export.c_parts import CPart, Precision
from vvdp.export.c_precision import growing, in_single
from vvdp.export.c_target import Load, counted_loads, missing_tools
from vvdp.systems.library_examples import FOLDER
from vvdp.systems.system import System, load_system, shipped_systems

PAGE = Path(__file__).parents[1] / "c-export.md"
EXAMPLE = "speed-from-edges"
"""The example of the event filter, which is no shipped system."""
SAMPLES = 200
"""Samples of a run over which instructions are counted."""
SIZES = ("<!-- sizes, made by docs/site/exported_programs.py -->\n", "<!-- end of the sizes -->\n")
TARGETS = ("<!-- targets, made by docs/site/exported_programs.py -->\n", "<!-- end of the targets -->\n")
SIZES_HEAD = "| system | program | functions | lines | memory | settings | arrays |\n|---|---|---|---|---|---|---|\n"
TARGETS_HEAD = (
    "| system | program | processor | precision | code | stack | memory | settings | mean | most |\n"
    "|---|---|---|---|---|---|---|---|---|---|\n"
)


def loaded(name: str) -> System:
    """A shipped system by its name, or the example of the event filter."""
    return load_system(str(Path(str(FOLDER), "programs", f"{EXAMPLE}.toml")) if name == EXAMPLE else name)


def programs() -> Iterator[tuple[str, str]]:
    """System and name of each program, the event filter last."""
    for name in sorted(shipped_systems()):
        yield from ((name, part) for part in loaded(name).model.programs)
    yield EXAMPLE, "speed"


def size_row(name: str, program: str) -> str:
    """The row of the first table."""
    system = loaded(name)
    made = c_part(system, program)
    found = facts(made, {f"{made.name}.c": facade_text(made), f"{made.name}_core.c": made.core.source}, 0)
    keys = ("functions", "lines", "memory_bytes", "settings_bytes", "stack_bytes")
    return f"| `{name}` | `{program}` | {' | '.join(str(found[key]) for key in keys)} |\n"


def target_rows(name: str, program: str) -> str:
    """The rows of the second table: a Cortex-M7 in double; a Cortex-M4 in single if the step allows it and its samples
    agree with those in double within a thousandth."""
    system = loaded(name)
    made = c_part(system, program)
    rows = _target_row(system, made, core=1)
    assert made.program is not None
    if next(growing(made.program, made.entries[0].blocks), ""):
        return rows
    try:
        return _target_row(system, in_single(made), core=0) + rows
    except RunError:
        return rows


def _target_row(system: System, part: CPart, core: int) -> str:
    load: Load = counted_loads(c_files(system, part, SAMPLES))[core]
    found = facts(part, {f"{part.name}{end}": "" for end in (".c", "_core.c")}, SAMPLES)
    precision = "single" if part.precision is Precision.SINGLE else "double"
    numbers = (load.code, load.stack, found["memory_bytes"], found["settings_bytes"], load.mean, load.most)
    name = f"| `{part.system}` | `{part.part}` | {load.core} | {precision} |"
    return f"{name} {' | '.join(map(str, numbers))} |\n"


def with_table(page: str, marks: tuple[str, str], table: str) -> str:
    """The page with a table between two marks."""
    before, rest = page.split(marks[0])
    return f"{before}{marks[0]}{table}{marks[1]}{rest.partition(marks[1])[2]}"


def main() -> None:
    """Writes both tables."""
    page = PAGE.read_text("utf-8")
    every = list(programs())
    page = with_table(page, SIZES, SIZES_HEAD + "".join(size_row(*each) for each in every))
    if missing := missing_tools():
        print(f"the second table stays as it is: {', '.join(missing)} not found")
    else:
        page = with_table(page, TARGETS, TARGETS_HEAD + "".join(target_rows(*each) for each in every))
    PAGE.write_text(page, "utf-8")


if __name__ == "__main__":
    main()
