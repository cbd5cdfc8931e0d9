"""Which numbers of a case follow a value: the same as one value after the other shows, with the same reasons."""

import numpy as np
import pytest

from vvdp.base.errors import VvdpError
from vvdp.simulation.layout import held_part, vectors
from vvdp.systems.changeable import VECTORS, Changeable, as_written, changeable_values, operation_of
from vvdp.systems.probing import Probe, Probing
from vvdp.systems.system import System, load_system

SHARES = (0.98, 0.99, 1.0, 1.01, 1.02)


def outside(system: System):
    calls = [(name, p.period, p.phase, p.latency) for name, p in system.model.programs.items()]
    return system.circuit.text, calls, system.stepping


def case_at(name: str, system: System, value: Changeable, number: float):
    """The vectors of a case with one other value, or the first line of what is wrong with it."""
    text = Probe(value.row, number).option
    try:
        other = load_system(name, [text])
    except (VvdpError, ValueError) as problem:
        return str(problem).splitlines()[0].removeprefix("--set: ")[:160]
    made, base = vectors(other.case), vectors(system.case)
    if outside(other) != outside(system):
        return "it changes the circuit itself, or from what numbers are counted"
    same = all(a.shape == b.shape for a, b in zip(made, base, strict=True))
    return made if same else "it changes how many numbers the circuit has"


def probes_of(value: Changeable) -> list[float]:
    low, number, high = value.low, value.number, value.high
    near = [float(f"{number * factor:.12g}") for factor in (0.93, 1.0, 1.11)]
    middle = float(f"{0.4 * low + 0.6 * high:.4g}")
    return sorted({low, *(x for x in near if low <= x <= high), number, middle, high})


def followers_alone(name: str, system: System, value: Changeable):
    """What follows a value, by one case for each of the numbers over its range."""
    probes, base, held = probes_of(value), vectors(system.case), held_part(system.case)
    rows = [case_at(name, system, value, x) for x in probes]
    assert not any(isinstance(row, str) for row in rows), rows
    found, si = [], [Probe(value.row, x).si for x in probes]
    for place, vector in enumerate(VECTORS):
        numbers = np.stack([row[place] for row in rows])
        for at in np.flatnonzero((numbers != base[place]).any(axis=0)):
            if not (vector == "command" and held.start <= at < held.stop):
                found.append((vector, int(at), operation_of(si, numbers[:, at].tolist())))
    return found


@pytest.mark.parametrize(
    "name",
    [
        "cylinder-stops",
        pytest.param("vvdp-duty-control", marks=pytest.mark.thorough),
        pytest.param("shared-supply", marks=pytest.mark.thorough),
    ],
)
def test_values_together_show_what_one_after_the_other_shows(name):
    system = load_system(name)
    values = changeable_values(system, outside)
    assert sum(not value.why_not for value in values) > 40
    for value in values:
        if not value.why_not:
            found = [(f.vector, f.place, (f.operation, f.constant)) for f in value.followers]
            assert found == followers_alone(name, system, value), value.row.setting
        elif value.why_not.startswith("nothing"):
            assert followers_alone(name, system, value) == [], value.row.setting


@pytest.mark.parametrize("name", ["cylinder-stops", pytest.param("vvdp-duty-control", marks=pytest.mark.thorough)])
def test_no_case_with_several_values_differs_from_one_alone(name):
    """What a case with several other values shows of each of them is what the case with it alone has, to the bit."""
    system = load_system(name)
    probing = Probing(system, outside)
    rows = [row for row in system.rows if np.isfinite(row.nominal) and row.table != "run" and row.nominal > 0.0]
    ranges = [
        tuple(Probe(row, x * as_written(row.nominal, row.kind)) for x in (0.98, 0.99, 1.0, 1.01, 1.02)) for row in rows
    ]
    usable = [each for each in ranges if not any(probing.find(each[at]).why_not for at in (0, -1))]
    probing.build_inner(usable)
    shared = [probe for each in usable for probe in each if (probe.row.setting, probe.number) in probing.together]
    assert len(shared) > 60
    for probe in shared:
        seen, alone = (look(probe).numbers[probing.counted] for look in (probing.view, probing.find))
        assert np.array_equal(seen, alone), probe.option
