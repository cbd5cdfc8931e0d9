"""Systems with their loop in C: a folder that repeats a run of vvdp, to the last bit."""

import ctypes
import re
import subprocess
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from tests.conftest import required_program
from tests.export.test_c_export import make
from tests.generator.c_way import compilers

from vvdp.base.errors import ConfigError
from vvdp.export.c_folder import exported_folder
from vvdp.export.c_machine import FAILED, MACHINE, c_machine, facade_text, header_text
from vvdp.export.c_machine_folder import expected_of
from vvdp.export.machine import machine_module
from vvdp.generator.binding import is_fused
from vvdp.generator.c_room import room_of
from vvdp.generator.library import C_LIBRARY, EXACT
from vvdp.simulation import places
from vvdp.simulation.run import simulate
from vvdp.systems.system import load_system, shipped_systems

pytestmark = pytest.mark.skipif(not is_fused(), reason="a run has other bits on a processor without fused operations")


def write_machine(folder, name, samples):
    """Writes the folder of a machine; what was exported."""
    made = exported_folder(load_system(name), MACHINE, samples)
    for file, text in made.files.items():
        (folder / file).write_text(text, "utf-8")
    return made


@pytest.mark.parametrize("name", ["prototype", "accumulator-charging"])
def test_the_folder_repeats_a_run_to_the_last_bit(name, tmp_path):
    made = write_machine(tmp_path, name, 30)
    done = make(tmp_path, "test")
    assert done.stderr == ""
    found = re.fullmatch(r"(\w+): 0 of (\d+) numbers differ from vvdp\n", done.stdout)
    assert found and found[1] == made.name
    assert int(found[2]) > 31 * 40
    assert make(tmp_path, "example").stderr == ""
    assert len(subprocess.run(["./example"], cwd=tmp_path, capture_output=True, check=True).stdout.splitlines()) == 3


def test_the_page_shows_what_the_folder_reports():
    """The number of compared numbers, for the default number of samples."""
    vectors = exported_folder(load_system("prototype"), MACHINE, 100).files["vectors.h"]
    counts = {name: int(count) for name, count in re.findall(r"COUNT_(\w+) = (\d+)", vectors)}
    total = sum(counts.values()) - counts["until"] - counts["times"]
    page = (Path(__file__).parents[2] / "docs" / "c-export.md").read_text("utf-8")
    assert f"prototype_machine: 0 of {total} numbers differ from vvdp\n" in page


@pytest.mark.thorough
@pytest.mark.parametrize("name", sorted(shipped_systems()))
def test_every_system_repeats_its_run(name, tmp_path):
    test_the_folder_repeats_a_run_to_the_last_bit(name, tmp_path)


def test_another_bit_is_reported(tmp_path):
    """The last bit of the last number, which is of the clock, is changed."""
    write_machine(tmp_path, "accumulator-charging", 10)
    before, mark, last = (tmp_path / "vectors.h").read_text("utf-8").rpartition("UINT64_C(0x")
    changed = f"{int(last[:16], 16) ^ 1:016x}"
    (tmp_path / "vectors.h").write_text(f"{before}{mark}{changed}{last[16:]}", "utf-8")
    done = make(tmp_path, "test", check=False)
    assert done.returncode != 0
    assert re.search(r": 1 of \d+ numbers differ from vvdp\nlargest difference: \S+ in number 28 of clock", done.stdout)


@pytest.mark.parametrize("name", ["accumulator-charging", pytest.param("prototype", marks=pytest.mark.thorough)])
def test_nothing_is_written_but_the_machine(name, tmp_path):
    """By `nm`: D and B are writable data, U is what must come from elsewhere."""
    made = write_machine(tmp_path, name, 3)
    make(tmp_path, "test")
    objects = [str(tmp_path / f"{made.name}{end}.o") for end in ("", "_core")]
    done = subprocess.run([required_program("nm"), *objects], capture_output=True, text=True, check=True)
    symbols = [line.split()[-2:] for line in done.stdout.splitlines() if line and not line.endswith(":")]
    assert [name for kind, name in symbols if kind in "DdBbC"] == []
    own = {name for kind, name in symbols if kind == "T"}
    assert {f"{made.name}_{each}" for each in ("start", "run", "outputs", "time")} <= own
    needed = {name for kind, name in symbols if kind == "U"} - own
    assert needed <= {*C_LIBRARY, *EXACT, "fma", "memcpy", "memset", "__stack_chk_fail", "_GLOBAL_OFFSET_TABLE_"}


@pytest.mark.thorough
def test_sanitisers_find_nothing(tmp_path):
    """Bounds of arrays, and all that C leaves undefined, over a run with marks and samples."""
    write_machine(tmp_path, "prototype", 60)
    checks = "-g -fsanitize=address,undefined -fno-sanitize-recover=all"
    command = ["make", "-s", "test", f"CC={required_program('cc')} {checks}"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")


class Record(ctypes.Structure):
    """Room for the rows of a run."""

    _fields_ = (
        ("times", ctypes.c_void_p), ("rows", ctypes.c_int64), ("states", ctypes.c_void_p),
        ("commands", ctypes.c_void_p), ("memories", ctypes.c_void_p), ("mark_times", ctypes.c_void_p),
        ("mark_states", ctypes.c_void_p), ("marks", ctypes.c_int64),
    )  # fmt: skip


class Machine:
    """A machine in C in this process."""

    def __init__(self, system, folder, compiler, flags=("-O2",)):
        self.made = made = c_machine(system)
        (folder / f"{made.name}.h").write_text(header_text(made))
        (folder / f"{made.name}.c").write_text(facade_text(made))
        (folder / f"{made.name}_core.h").write_text(made.core.header)
        (folder / f"{made.name}_core.c").write_text(made.core.source)
        command = [compiler, *made.flags, *flags, "-fPIC", "-shared", "-o", "machine.so"]
        files = [f"{made.name}.c", f"{made.name}_core.c"]
        subprocess.run([*command, *files, "-lm"], cwd=folder, check=True)
        self.library = ctypes.CDLL(str(folder / "machine.so"))
        self.kept = np.zeros(made.size // 8)
        self.place = ctypes.c_void_p(self.kept.ctypes.data)
        self.run = getattr(self.library, f"{made.name}_run")
        self.start()

    def start(self):
        """Sets it to the values of the system."""
        getattr(self.library, f"{self.made.name}_start")(self.place)

    def member(self, name):
        """A member as an array that shares its numbers."""
        at = 0
        for own, each in self.made.content.items():
            if own == name:
                return self.kept[at : at + each.size]
            at += max(1, each.size)
        raise KeyError(name)

    def carry(self, end, record=None):
        """Carries it on; the answer."""
        handed = None if record is None else ctypes.byref(record)
        return self.run(self.place, ctypes.c_double(end), handed)


def rows_of(machine, expected):
    """What a machine leaves on the way that vvdp has gone, by the names of `expected`."""
    found = {name: np.zeros_like(each) for name, each in expected.numbers.items() if not name.startswith("last_")}
    places_ = {name: each.ctypes.data for name, each in found.items()}
    rows, marks = expected.times.size, found["mark_times"].size
    record = Record(times=expected.times.ctypes.data, rows=rows, marks=marks, **places_)
    assert machine.carry(expected.until, record) == 0
    return {**found, **{f"last_{name}": machine.member(name) for name in ("state", "command", "memory", "clock")}}


@pytest.mark.thorough
@pytest.mark.skipif(not compilers(), reason="no C compiler")
@pytest.mark.parametrize("name", sorted(shipped_systems()))
def test_no_number_of_a_whole_run_differs(name, tmp_path):
    """Every row, command, memory and mark of the first half second, recorded as `vvdp run` does, and all counts."""
    system = load_system(name, (), "0.5 s")
    stepping = replace(system.stepping, average_from=None)  # where means begin, a run ends a step
    expected = expected_of(simulate(system.model, system.case, stepping))
    for number, (compiler, flags) in enumerate(
        [(compiler, ("-O2",)) for compiler in compilers()] + [(compilers()[0], ("-O3", "-march=native"))]
    ):
        folder = tmp_path / str(number)
        folder.mkdir()
        found = rows_of(Machine(system, folder, compiler, flags), expected)
        for key in found:
            assert found[key].tobytes() == expected.numbers[key].tobytes(), (key, compiler, flags)
        assert expected.times.size > 2000


@pytest.mark.skipif(not compilers(), reason="no C compiler")
def test_a_machine_is_carried_on_by_samples_and_copied(tmp_path):
    """From sample to sample it has the bits of one call; a copy of it goes on with the same bits."""
    system = load_system("buck-converter")
    machine = Machine(system, tmp_path, compilers()[0])
    assert machine.carry(0.04) == 0
    whole = machine.kept.copy()
    machine.start()
    for sample in range(1, 41):
        assert machine.carry(sample * system.stepping.sample_period) == 0
        if sample == 17:
            copied = machine.kept.copy()
    state, counts = machine.member("state").copy(), machine.member("clock")[: places.EVALUATIONS + 1].copy()
    assert machine.kept.tobytes() == whole.tobytes()
    machine.kept[:] = copied
    assert machine.carry(0.04) == 0
    assert machine.member("state").tobytes() == state.tobytes()
    assert machine.member("clock")[: places.EVALUATIONS + 1].tobytes() == counts.tobytes()


@pytest.mark.thorough
@pytest.mark.skipif(not compilers(), reason="no C compiler")
def test_a_run_that_cannot_go_on_says_why(tmp_path):
    machine = Machine(load_system("buck-converter"), tmp_path, compilers()[0])
    machine.member("state")[0] = np.nan
    assert machine.carry(0.01) == places.NOT_FINITE < FAILED
    machine.start()
    assert machine.carry(0.01) == places.DONE


def test_an_unknown_part_names_what_there_is():
    with pytest.raises(ConfigError, match="machine"):
        exported_folder(load_system("prototype"), "machin", 3)


def test_all_arrays_of_a_machine_have_a_known_length():
    """Memories and readings of this program are arrays, whose lengths a simulation reads from the parameters."""
    system = load_system("displacement-control")
    rooms = room_of(machine_module(system.model, system.case))
    assert rooms["run"] is not None
    assert 0 < rooms["run"][0] < 1000  # arrays of a sample, given back by each call
