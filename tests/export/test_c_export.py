"""Parts of systems as C: a folder that proves itself, and says so if a bit is another."""

import importlib.util
import re
import subprocess
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest
from tests.conftest import required_program

from vvdp.base.arrays import Array
from vvdp.base.errors import ConfigError
from vvdp.base.kinds import PRESSURE_LEVEL, Angle, Pressure
from vvdp.export.c_folder import (
    CIRCUIT,
    c_files,
    c_part,
    expected_values,
    part_code,
    sampled_values,
)
from vvdp.export.c_parts import OUT, function_of, module_of
from vvdp.export.c_structs import Classes, initial_text, store_lines, struct_text, value_text
from vvdp.export.c_target import TOOLS
from vvdp.generator.library import C_LIBRARY, EXACT
from vvdp.generator.source import LanguageError
from vvdp.simulation.values import flat
from vvdp.systems.system import load_system, shipped_systems


class Inner(NamedTuple):
    angle: Angle
    row: Array


class Outer(NamedTuple):
    pressure: Pressure
    inner: Inner
    grid: Array
    nothing: Array


VALUE = Outer(2e5, Inner(0.5, np.array([1.0, -np.inf])), np.array([[1.0, 2.0], [3.0, 4.0]]), np.zeros(0))


def test_a_struct_has_units_and_the_order_of_flat():
    text = struct_text("part_memory", VALUE, "What is kept.")
    members = re.findall(r"(double \w+[\[\]0-9]*|struct|} \w+);?", text)
    assert members == ["struct", "double pressure", "struct", "double angle", "double row[2]", "} inner",
                       "double grid[2][2]", "} part_memory"]  # fmt: skip
    assert f"double pressure; /* [Pa] {PRESSURE_LEVEL.name} */" in text
    assert "nothing" not in text  # C has no array without numbers
    numbers = re.findall(r"-?(?:\d+\.\d+|INFINITY)", initial_text("k", "v", VALUE, ""))
    assert [float(n.replace("INFINITY", "inf")) for n in numbers] == flat(VALUE).tolist()


def test_a_value_is_read_from_its_numbers_and_written_back():
    classes = Classes()
    text = value_text(VALUE, "v", iter(range(99)), classes)
    known = {name: cls for cls, name in classes.names.items()}
    found = eval(text, {**known, "v": flat(VALUE)})
    assert flat(found).tolist() == flat(VALUE).tolist()
    assert found.grid.shape == (2, 2)
    out = np.zeros(flat(VALUE).size)
    exec("\n".join(store_lines(VALUE, "found", "out")), {"found": found, "out": out})
    assert out.tolist() == flat(VALUE).tolist()


PARTS = [("prototype", "estimate"), ("buck-converter", CIRCUIT), ("displacement-chapter6", "control")]


@pytest.mark.parametrize(("name", "part"), PARTS)
def test_an_exported_folder_has_the_expected_bits(name, part, tmp_path):
    made = write_folder(tmp_path, name, part, 40)
    done = make(tmp_path, "test")
    assert done.stderr == ""
    assert done.stdout.splitlines() == [
        f"{made.name}_{entry.name}: 40 of 40 samples have the same bits" for entry in made.entries
    ]
    assert make(tmp_path, "example").stderr == ""
    assert len(subprocess.run(["./example"], cwd=tmp_path, capture_output=True, check=True).stdout.splitlines()) == 3


@pytest.mark.thorough
@pytest.mark.parametrize("name", sorted(shipped_systems()))
def test_every_part_of_a_system_has_the_expected_bits(name, tmp_path):
    for part in (CIRCUIT, *load_system(name).model.programs):
        (tmp_path / part).mkdir()
        test_an_exported_folder_has_the_expected_bits(name, part, tmp_path / part)


def make(folder, target, check=True):
    command = ["make", "-s", target, f"CC={required_program('cc')} -Werror"]
    required_program("make")
    return subprocess.run(command, cwd=folder, capture_output=True, text=True, check=check)


def test_objects_have_no_writable_memory_and_need_the_c_library_only(tmp_path):
    """By `nm`: D and B are writable data, U is what must come from elsewhere."""
    made = write_folder(tmp_path, "prototype", "estimate", 3)
    make(tmp_path, "test")
    objects = [str(tmp_path / f"{made.name}{end}.o") for end in ("", "_core")]
    done = subprocess.run([required_program("nm"), *objects], capture_output=True, text=True, check=True)
    symbols = [line.split()[-2:] for line in done.stdout.splitlines() if line and not line.endswith(":")]
    assert [name for kind, name in symbols if kind in "DdBbC"] == []
    own = {name for kind, name in symbols if kind == "T"}
    needed = {name for kind, name in symbols if kind == "U"} - own
    assert needed <= {*C_LIBRARY, *EXACT, "fma", "memcpy", "memset", "__stack_chk_fail", "_GLOBAL_OFFSET_TABLE_"}
    assert "erfc" in needed


@pytest.mark.thorough
def test_sanitisers_find_nothing(tmp_path):
    """Bounds of arrays, and all that C leaves undefined, over the samples of the vectors."""
    write_folder(tmp_path, "prototype", "estimate", 30)
    checks = "-g -fsanitize=address,undefined -fno-sanitize-recover=all"
    command = ["make", "-s", "test", f"CC={required_program('cc')} {checks}"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")


def write_folder(folder, name, part, samples):
    """Writes an exported folder; what was exported."""
    system = load_system(name)
    made = c_part(system, part)
    for file, text in c_files(system, made, samples).items():
        (folder / file).write_text(text, "utf-8")
    return made


def test_another_bit_is_reported(tmp_path):
    """One number of one sample is changed by its last bit."""
    write_folder(tmp_path, "accumulator-charging", "unloading", 10)
    assert make(tmp_path, "test").returncode == 0
    expected = (tmp_path / "vectors.h").read_text("utf-8").rpartition("UINT64_C(0x")
    changed = f"{int(expected[2][:16], 16) ^ 1:016x}"
    (tmp_path / "vectors.h").write_text(f"{expected[0]}{expected[1]}{changed}{expected[2][16:]}", "utf-8")
    done = make(tmp_path, "test", check=False)
    assert done.returncode != 0
    assert re.search(r"9 of 10 samples have the same bits\nlargest difference: \S+ in number \d+ of \w+", done.stdout)


def test_the_expected_bits_are_those_of_the_python_text():
    """Away from functions of the C library, machine code and plain Python have the same bits."""
    system = load_system("displacement-chapter6")
    part = c_part(system, "control")
    code = part_code(part)
    times, drawn = sampled_values(system, part, code, 30)
    assert np.ptp(list(drawn), axis=0).max() > 0.0
    (entry,) = part.entries
    expected = expected_values(part, code, times, drawn)[entry.name]
    kept = {block.name: flat(block.value) for block in entry.arguments}
    function = function_of(entry)
    for t, values, wanted in zip(times, drawn, expected, strict=True):
        kept["reading"] = values
        kept |= {block.name: np.zeros(block.size) for block in entry.arguments if block.role == OUT}
        function(t, *(kept[block.name] for block in entry.arguments))
        for name, numbers in wanted.items():
            assert np.allclose(kept[name], numbers, rtol=1e-12, atol=1e-300), name
            kept[name] = numbers.copy()


@pytest.mark.thorough
def test_the_text_is_the_same_every_time():
    system = load_system("prototype")
    first, again = (c_files(system, c_part(system, "estimate"), 3) for _ in range(2))
    assert first == again
    assert all("/home" not in text and "/work" not in text for text in first.values())


def test_an_unknown_part_is_refused_with_those_there_are():
    with pytest.raises(ConfigError, match="encoder"):
        c_part(load_system("prototype"), "encodr")


def dictionary_step(t, memory, reading, settings):
    return memory, {"a": reading}


def test_a_step_outside_the_language_is_refused_with_file_and_line():
    system = load_system("accumulator-charging")
    (entry,) = c_part(system, "unloading").entries
    own = type(entry)(entry.name, entry.about, entry.blocks, entry.lines, {"function": dictionary_step}, entry.classes)
    line = dictionary_step.__code__.co_firstlineno + 1
    with pytest.raises(LanguageError, match=rf"test_c_export\.py:{line}: "):
        module_of([own])


PAGE = Path(__file__).parents[2] / "docs" / "c-export.md"


@pytest.fixture(scope="module")
def tables():
    """The script that writes the tables of the page."""
    script = PAGE.parent / "site" / "exported_programs.py"
    spec = importlib.util.spec_from_file_location("exported_programs", script)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def table(tables, marks):
    """The rows of a table of the page."""
    return PAGE.read_text("utf-8").partition(marks[0])[2].partition(marks[1])[0].splitlines(keepends=True)[2:]


def test_the_page_shows_the_size_of_programs(tables):
    rows = table(tables, tables.SIZES)
    for each in (("accumulator-charging", "unloading"), ("displacement-chapter6", "control")):
        assert tables.size_row(*each) in rows


@pytest.mark.thorough
def test_the_page_shows_every_program(tables):
    assert table(tables, tables.SIZES) == [tables.size_row(*each) for each in tables.programs()]


COLUMNS = re.compile(r"(?<=\| )[\d]+(?= \|)")


@pytest.mark.parametrize(
    "each",
    [
        ("accumulator-charging", "unloading"),
        pytest.param(("speed-from-edges", "speed"), marks=pytest.mark.thorough),
        pytest.param(("displacement-control", "axial_observer"), marks=pytest.mark.thorough),
        pytest.param(("transmission-speed-control", "speed_control"), marks=pytest.mark.thorough),
    ],
)
def test_the_page_shows_programs_on_the_target(tables, each):
    """To 3 % or 16: other versions of the compiler and of its library have other numbers."""
    for name in TOOLS:
        required_program(name, "arm")
    found = tables.target_rows(*each).splitlines(keepends=True)
    shown = [row for row in table(tables, tables.TARGETS) if row.startswith(f"| `{each[0]}` | `{each[1]}` |")]
    assert len(found) == len(shown)
    for one, other in zip(found, shown, strict=True):
        assert [int(x) for x in COLUMNS.findall(one)] == pytest.approx(
            [int(x) for x in COLUMNS.findall(other)], rel=0.03, abs=16
        )


def test_every_program_is_in_both_tables(tables):
    names = [f"| `{system}` | `{part}` |" for system, part in tables.programs()]
    for marks in (tables.SIZES, tables.TARGETS):
        rows = table(tables, marks)
        assert [name for name in names if not any(row.startswith(name) for row in rows)] == []
    assert sum("| single |" in row for row in table(tables, tables.TARGETS)) == 15
