"""Steps in single precision: which are allowed, their text, and how far the event filter is from double precision."""

import ctypes
import re
import subprocess
from pathlib import Path

import numpy as np
import pytest
from tests.conftest import required_program

from vvdp.base.errors import ConfigError
from vvdp.base.kinds import ANGLE, TIME
from vvdp.export.c_folder import c_part, exported_folder, facade_text, header_text
from vvdp.export.c_parts import Precision
from vvdp.export.c_precision import growing, in_single
from vvdp.generator.c_single import LEAST, MOST, fits_single, require_single, single_text
from vvdp.generator.kinds import FLOAT
from vvdp.generator.source import LanguageError
from vvdp.generator.unit import Options, Unit
from vvdp.generator.verify import verify
from vvdp.simulation.values import leaves
from vvdp.systems.system import load_system, shipped_systems

EXAMPLE = Path(__file__).parents[2] / "src" / "vvdp" / "systems" / "examples" / "programs" / "speed-from-edges.toml"
PAGE = Path(__file__).parents[2] / "docs" / "c-export.md"
HOUR, HOURS = 3_600_000, 16


def test_text_in_single_precision_has_no_double():
    """Types, literals and functions of the C library change; names, whole numbers and comments do not."""
    apart = '/* a double of 2.0 */\n#include "double.h"\n'
    text = apart + "double sin2(double x) { return sin(x.sin) + 1e-3 * a[10] - 2.5e+01; }"
    expected = apart + "float sin2(float x) { return sinf(x.sin) + 1e-3f * a[10] - 2.5e+01f; }"
    assert single_text(text) == expected


def test_numbers_that_a_float_holds():
    """By IEEE 754: the smallest normal number is 2^-126, the largest (2 - 2^-23) 2^127."""
    assert (LEAST, MOST) == (2.0**-126, (2.0 - 2.0**-23) * 2.0**127)
    assert all(map(fits_single, (0.0, LEAST, -MOST, np.inf, np.nan)))
    assert not any(map(fits_single, (1e-300, -0.9 * LEAST, 1e39)))


def faint(x):
    x = x + 1.0
    return x * 1e-300


def test_a_literal_that_no_float_holds_is_refused_with_its_line():
    unit = Unit(Options())
    unit.add(faint, [FLOAT], "faint")
    line = faint.__code__.co_firstlineno + 2
    with pytest.raises(
        LanguageError, match=rf"test_single_precision\.py:{line}: 1e-300 is no number .*; write one from"
    ):
        require_single(verify(unit.module()))


def refusal_of(name, part):
    with pytest.raises(ConfigError) as refused:
        exported_folder(load_system(name), part, 3, Precision.SINGLE)
    assert "\n" not in str(refused.value)
    return str(refused.value)


def test_steps_that_work_with_numbers_that_grow_are_refused():
    assert "memory.time is a time, which grows" in refusal_of("prototype", "encoder")
    assert "only the step of a program" in refusal_of("prototype", "circuit")
    assert "only the step of a program" in refusal_of("prototype", "machine")


def test_settings_that_no_float_holds_are_refused():
    system = load_system(str(EXAMPLE), ["programs.speed.ripple_drift=1e-40 1/s"])
    with pytest.raises(ConfigError, match=r"settings\.ripple_drift, 1e-40, is no number of single precision"):
        in_single(c_part(system, "speed"))


def test_a_folder_in_single_precision_compares_with_double(tmp_path):
    """Half a second of the example: within 0.1 % of the largest value of each number."""
    made = exported_folder(load_system(str(EXAMPLE)), "speed", 300, Precision.SINGLE)
    for name, text in made.files.items():
        (tmp_path / name).write_text(text, "utf-8")
    own = "".join(text for name, text in made.files.items() if re.match(r"speed_\w+\.[ch]$|example", name))
    assert not re.search(r"\bdouble\b", re.sub(r"/\*.*?\*/|\"[^\"]*\"", "", own, flags=re.DOTALL))
    compiler = f"CC={required_program('cc')} -Werror -Wdouble-promotion"
    done = subprocess.run(["make", "-s", "test", compiler], cwd=tmp_path, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")
    share = float(re.search(r"of memory, (\S+) of its largest value", done.stdout)[1])
    assert 1e-8 < share < 1e-4
    assert made.facts["memory_bytes"] == 4 * 68
    text = (tmp_path / "vectors.h").read_text("utf-8")  # a wrong speed is found
    (tmp_path / "vectors.h").write_text(text.replace("UINT64_C(0x4069", "UINT64_C(0x4059"), "utf-8")
    done = subprocess.run(["make", "-s", "test", compiler], cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode != 0


@pytest.mark.parametrize(("name", "part"), [("prototype", "estimate"), ("digital-pump-control", "pistons")])
def test_steps_with_sines_compare_with_double(tmp_path, name, part):
    """Ripples of three a turn, and pistons by the angle of the shaft: angles beyond an eighth of a turn."""
    made = exported_folder(load_system(name), part, 300, Precision.SINGLE)
    for file, text in made.files.items():
        (tmp_path / file).write_text(text, "utf-8")
    words = ["make", "-s", "test", f"CC={required_program('cc')}"]
    done = subprocess.run(words, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")
    assert float(re.search(r"of \w+, (\S+) of its largest value", done.stdout)[1]) < 5e-4


@pytest.fixture(scope="module")
def course(tmp_path_factory):
    """A function that runs a course of samples: differences, what passed, and the memory at the end."""
    folder, system = tmp_path_factory.mktemp("hour"), load_system(str(EXAMPLE))
    for own, part in (("edges", "edges"), ("twice", "speed"), ("single", "speed")):
        made = c_part(system, part)
        made = in_single(made) if own == "single" else made
        written = single_text if own == "single" else str
        texts = {".h": written(header_text(made)), ".c": written(facade_text(made))}
        texts |= {"_core.h": made.core.header, "_core.c": made.core.source}
        for end, text in texts.items():
            (folder / f"{own}{end}").write_text(text.replace(made.name, own), "utf-8")
    sources = [f"{own}{end}.c" for own in ("edges", "twice", "single") for end in ("", "_core")]
    flags = ["-std=c99", "-ffp-contract=off", "-O2", "-fPIC", "-shared", "-I.", "-o", "hour.so"]
    command = [required_program("cc"), *flags, *sources, str(Path(__file__).with_name("hour.c")), "-lm"]
    subprocess.run(command, cwd=folder, check=True)
    library = ctypes.CDLL(str(folder / "hour.so"))

    def run(samples, seed):
        found = np.zeros(7 + 256)
        assert library.course(samples, ctypes.c_uint64(seed), found.ctypes.data_as(ctypes.c_void_p)) == 0
        return found

    return run


def test_two_minutes_stay_close_to_double_precision(course):
    """Within 1e-3 rad and 0.02 rad/s, over standstills and reversals."""
    angle, speed, beyond, edges, _, standing, back = course(120_000, 1)[:7]
    assert (beyond, angle < 1e-3, speed < 0.02) == (0.0, True, True)
    assert edges > 4000
    assert min(standing, back) > 10_000


@pytest.mark.thorough
def test_an_hour_stays_close_to_double_precision(course):
    """The first of the hours; no number of the memory has grown with the time or with the revolutions."""
    angle, speed, beyond, edges, revolutions, standing, back = (found := course(HOUR, 0))[:7]
    assert (beyond, angle < 1e-3, speed < 0.02) == (0.0, True, True)
    assert edges > 190_000
    assert revolutions > 20_000
    assert min(standing, back) > 500_000
    first = load_system(str(EXAMPLE)).case.memory["speed"]
    kinds = [(path, kind) for path, value, kind in leaves(first) for _ in range(int(np.size(value)))]
    limits = {ANGLE: 8.0, TIME: 30.0}  # less than a revolution and a sector; six times the longest standstill
    bounded = {path: number for (path, kind), number in zip(kinds, found[7:], strict=False) if kind in limits}
    assert {"filter.belief.angle", "filter.last.time", "since"} <= bounded.keys()
    assert all(abs(bounded[path]) < limits[kind] for path, kind in kinds if path in bounded)


@pytest.mark.thorough
def test_the_page_counts_the_hours_without_a_deviation(course):
    """The estimate jumps where a decision falls; one hour in several has a decision that rounding turns."""
    found = [course(HOUR, seed)[:7] for seed in range(HOURS)]
    calm = [each for each in found if not each[2]]
    page = PAGE.read_text("utf-8")
    stated = re.search(r"In (\d+) of (\d+) hours no sample .*?, the\s+others have (\d+) samples", page, re.DOTALL)
    assert [int(each) for each in stated.groups()] == [len(calm), HOURS, sum(int(each[2]) for each in found)]
    standing, back = (np.mean([each[i] for each in found]) / HOUR for i in (5, 6))
    assert f"({standing:.0%} of the time at rest, {back:.0%} backwards)".replace("%", " %") in page
    assert f"of {HOURS * HOUR / 1e6:.1f} million" in page


@pytest.mark.thorough
def test_every_step_that_allows_it_is_close_in_single_precision(tmp_path):
    """All programs of the shipped systems without a number that grows: `make test` passes."""
    compiler = f"CC={required_program('cc')} -Werror -Wdouble-promotion"
    allowed = set()
    for name in sorted(shipped_systems()):
        system = load_system(name)
        for part in system.model.programs:
            made = c_part(system, part)
            if next(growing(made.program, made.entries[0].blocks), ""):
                continue
            folder = tmp_path / f"{name}-{part}"
            folder.mkdir()
            for file, text in exported_folder(system, part, 60, Precision.SINGLE).files.items():
                (folder / file).write_text(text, "utf-8")
            done = subprocess.run(
                ["make", "-s", "test", compiler], cwd=folder, capture_output=True, text=True, check=False
            )
            assert (done.returncode, done.stderr) == (0, ""), (name, part, done.stdout)
            allowed.add(f"{name} {part}")
    assert allowed == {
        "accumulator-charging unloading", "axial-chamber drive_wanted", "axial-gerotor drive_wanted",
        "axial-gerotor drive_law", "digital-pump-control pistons", "prototype estimate",
        "transmission-speed-control forward", "vvdp-duty-control estimate", "vvdp-duty-control asked",
        "vvdp-duty-control-gerotor estimate", "vvdp-duty-control-gerotor asked",
        "vvdp-duty-control-gerotor position_control", "displacement-control estimate",
        "displacement-control-gerotor estimate", "displacement-control-gerotor position_control",
    }  # fmt: skip
