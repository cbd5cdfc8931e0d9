"""Every key and table of every file that vvdp reads is known or refused, with what was perhaps meant."""

import re

import pytest

from vvdp.base.errors import ConfigError, Fault
from vvdp.base.tables import parsed_table
from vvdp.design.problem import cycle_points
from vvdp.geometry.shape_tables import shape_table
from vvdp.machines.duties import known_cylinder, read_duty
from vvdp.machines.recorded_cycle import recorded_cycle
from vvdp.offline.config import load_estimation
from vvdp.studies.study import load_study
from vvdp.systems.system import built_system, load_system, shipped_systems

DRAWN = """title = "Two orifices"

[nodes.supply]
type = "pressure-source"
pressure = "100 bar"

[nodes.tank]
type = "tank"

[nodes.middle]
type = "volume"
volume = "10 cc"
start = "50 bar"

[components.first]
type = "orifice"
a = "supply"
b = "middle"
area = "5 mm^2"
discharge_coefficient = "0.6"
transition_pressure = "0.1 bar"

[components.second]
type = "orifice"
a = "middle"
b = "tank"
area = "5 mm^2"
discharge_coefficient = "0.6"
transition_pressure = "0.1 bar"

[run]
until = "1 s"
"""


def faults(text: str) -> list[str]:
    """What is wrong with a system file; empty where nothing is."""
    try:
        built_system(parsed_table(text, "my.toml"), "my")
    except ConfigError as problem:
        return [str(fault) for fault in problem.faults]
    return []


def test_the_file_itself_is_sound():
    assert faults(DRAWN) == []


@pytest.mark.parametrize(
    ("begin", "said"),
    [
        ('until = "5 s"', "my.toml:1: until: unknown key; did you mean 'run.until'?"),
        ('average_from = "1 s"', "my.toml:1: average_from: unknown key; did you mean 'run.average_from'?"),
        ('oil_temperature = "80 degC"', "my.toml:1: oil_temperature: unknown key; did you mean 'operation.oil_temp"),
        ('titles = "x"', "my.toml:1: titles: unknown key; did you mean 'title'?"),
        ("colour = 3", "my.toml:1: colour: unknown key; expected one of circuit, components, "),
        ("operation = 3", "my.toml:1: operation: 3 is not a table"),
        ("limits = 3", "my.toml:1: limits: 3 is not a table"),
        ('oil = "water"', "my.toml:1: oil: 'water' is not a table"),
        ("programs = []", "my.toml:1: programs: [] is not a table"),
    ],
)
def test_keys_before_the_first_table_of_a_drawn_file(begin, said):
    (told,) = faults(f"{begin}\n{DRAWN}")
    assert told.startswith(said)


def test_the_title_is_a_text():
    assert faults(DRAWN.replace('"Two orifices"', "3")) == ["my.toml:1: title: 3 is not a text in quotes"]


def test_keys_before_the_first_table_of_a_file_that_names_its_circuit():
    text = shipped_systems()["prototype"]
    assert faults(f'until = "5 s"\n{text}') == ["my.toml:1: until: unknown key; did you mean 'run.until'?"]


@pytest.mark.parametrize("word", ["{}", "[]", "3", "true"])
@pytest.mark.parametrize("table", ["nodes.tank", "components.first"])
def test_a_type_that_is_no_text(table, word):
    head = f"[{table}]\ntype = "
    assert head in DRAWN
    before, _, after = DRAWN.partition(head)
    told = faults(f"{before}{head}{word}\n{after.partition(chr(10))[2]}")
    assert len(told) == 1 and f"{table}: type " in told[0] and "is unknown; expected one of" in told[0]


def test_a_shaft_has_no_oil():
    text = DRAWN.replace("[run]", '[nodes.shaft]\ntype = "driven-shaft"\nspeed = "100 rpm"\noil = "other"\n[run]')
    (told,) = faults(text)
    assert told.endswith("nodes.shaft.oil: unknown key; expected one of rated_power, speed")


@pytest.mark.parametrize("name", [name for name, text in shipped_systems().items() if "[[" not in text])
def test_each_table_of_each_shipped_file_refuses_a_key_that_it_does_not_have(name):
    """One key more in each table, at once: each is named; parts are drawn out first, programs are read before their
    tables, and [geometry] when all others are sound."""
    text = shipped_systems()[name]
    tables = re.findall(r"^\[(.*)\]", text, re.MULTILINE)
    parts = [each for each in tables if each.startswith("parts.")]
    programs = [each for each in tables if each.startswith("programs.")]
    others = [each for each in tables if each not in ("geometry", "faults", *parts, *programs)]
    for chosen in (parts, programs, others, {"geometry"} & set(tables)):
        head = rf"^\[({'|'.join(chosen)})\]"
        told = faults(re.sub(head, r"[\1]\nzzz = 1", text, flags=re.MULTILINE)) if chosen else []
        said = "\n".join(told)  # of a key at its full and at its short path: one of them names both
        assert [table for table in chosen if f"{table}.zzz" not in said] == []


STUDY = 'system = "prototype"\noutputs = ["efficiency"]\n'


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ('titel = "x"\n' + STUDY + '[grid]\n"a.b" = ["1"]', ":1: titel: unknown key; did you mean 'title'?"),
        (STUDY + '[grids]\n"a.b" = ["1"]', ":3: grids: unknown table; did you mean 'grid'?"),
        (STUDY + '[random]\ncount = 1\nseeds = 1\nseed = 1\n[random.spreads]\n"a.b" = { uniform = ["1", "2"] }',
         ":5: random.seeds: unknown key; did you mean 'seed'?"),
        (STUDY + '[settings]\n"a.b" = "1"\n[grid]\n"a.b" = ["1", "2"]', ":4: settings.a.b: is in [grid] as well; "),
        (STUDY + '[settings]\n"a.b" = "1"\n[[cases]]\n"a.b" = "2"', ":4: settings.a.b: is in [[cases]] as well; "),
        (STUDY + '[[cases]]\n"a.b" = "2"\n[[cases]]\nb = "2"', ":6: cases.2.b: expected a key of the form"),
        ("title = 3\n" + STUDY + '[grid]\n"a.b" = ["1"]', ":1: title: 3 is not a text in quotes"),
    ],
)  # fmt: skip
def test_studies(tmp_path, text, said):
    path = tmp_path / "study.toml"
    path.write_text(text)
    with pytest.raises(ConfigError) as refused:
        load_study(path)
    assert said in str(refused.value)


def test_a_grid_is_refused_before_it_is_made(tmp_path):
    path = tmp_path / "study.toml"
    values = ", ".join(f'"{k}"' for k in range(400))
    path.write_text(STUDY + "[grid]\n" + "".join(f'"a.{name}" = [{values}]\n' for name in "bcd"))
    with pytest.raises(ConfigError, match=r"grid: 400 x 400 x 400 = 64000000 points; must be at most 1000000"):
        load_study(path)
    path.write_text(STUDY + f'[grid]\n"a.b" = [{values}]\n[random]\ncount = 2501\nseed = 1\n'
                    '[random.spreads]\n"a.c" = { uniform = ["1", "2"] }\n')  # fmt: skip
    with pytest.raises(
        ConfigError, match="2501 draws at each of 400 points are 1000400 cases; must be at most 1000000"
    ):
        load_study(path)


def test_files_of_other_commands(tmp_path):
    path = tmp_path / "my.toml"
    path.write_text('sectors = 8\n[sensor]\nwave = "a"\n[fliter]\na = 1\n')
    with pytest.raises(ConfigError) as refused:
        load_estimation(path)
    assert "my.toml:1: sectors: unknown key" in str(refused.value)
    assert "my.toml:4: fliter: unknown table; did you mean 'filter'?" in str(refused.value)
    path.write_text('units = "mm"\n[geometry]\n')
    with pytest.raises(ConfigError, match=r"my.toml:1: units: unknown key; expected one of geometry"):
        shape_table(str(path))
    path.write_text("point = 1\n[[points]]\nweight = 1\n")
    found: list[Fault] = []
    cycle_points(path, load_system("prototype"), found)
    assert [str(fault) for fault in found] == [f"{path}:1: point: unknown key; did you mean 'points'?"]


@pytest.mark.parametrize(
    ("head", "said"),
    [
        ("time,position,force,position", "position: 2 columns have this name; leave one"),
        ("time,position,force,forces", "forces: unknown column; did you mean 'force'?"),
        ("time,position,force,oil", "oil: unknown column; expected one of force, position, time"),
    ],
)
def test_columns_of_a_cycle(tmp_path, head, said):
    path = tmp_path / "cycle.csv"
    path.write_text(f"{head}\n0,0.1,0,0\n1,0.2,0,0\n2,0.1,0,0\n")
    with pytest.raises(ConfigError) as refused:
        read_duty(path, *known_cylinder())
    assert str(refused.value) == f"{path}:1: {said}"


def test_a_cycle_with_a_cell_without_end(tmp_path):
    path = tmp_path / "cycle.csv"
    path.write_text("time,position,force\n0,0.1," + "9" * 200_000 + "\n")
    with pytest.raises(ConfigError, match="cannot be read: field larger than field limit"):
        read_duty(path, *known_cylinder())


def test_a_recorded_cycle_with_two_columns_of_one_name(tmp_path):
    path = tmp_path / "log.csv"
    path.write_text("time,position,position\n0,0.1,0.3\n1,0.2,0.4\n2,0.1,0.3\n")
    with pytest.raises(ConfigError, match="has several columns 'position'; leave one"):
        recorded_cycle(path)


FAULT = "\n[faults.other]\n"


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ('value = "components.first.area"\nbecomes = "1 mm^2"\nbegin = { step = ["0 s", "1 s"], at = "1 s" }',
         "faults.other.begin: at, step; expected a value that does not change"),
        ('value = "components.first.area"\nbecomes = "1 mm^2"\nbegin = { value = "1 s", unit = "s" }',
         "faults.other.begin: unit; expected a value that does not change"),
        ('value = "components.first.a"\nbecomes = "tank"',
         "'components.first.a' is no value that can be another; expected one of components.first.area"),
        ('value = "components.first.type"\nbecomes = "check-valve"', "is no value that can be another"),
        ('value = "nodes.middle"\nbecomes = { type = "tank" }', "is no value that can be another"),
    ],
)  # fmt: skip
def test_faults_that_are_no_values(text, said):
    told = "\n".join(faults(DRAWN + FAULT + text))
    assert said in told


def test_a_fault_of_a_value_is_taken():
    assert faults(DRAWN + FAULT + 'value = "components.first.area"\nbecomes = "1 mm^2"') == []
