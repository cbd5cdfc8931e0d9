"""Directional derivatives of FMUs for model exchange, against differences of their own rates and against CasADi."""

import ctypes
from functools import cache

import casadi
import fmpy
import fmpy.fmi2
import fmpy.fmi3
import numpy as np
import pytest
from lxml import etree
from tests.export.test_fmu import PERIOD, pytestmark, run_of
from tests.export.test_model_exchange import made

from vvdp.export.fmu_model import INPUT
from vvdp.simulation.layout import vectors
from vvdp.simulation.parts import outputs_part
from vvdp.simulation.symbols import Op
from vvdp.simulation.trace import trace
from vvdp.systems.system import load_system, shipped_systems

__all__ = ["pytestmark"]


class Solver:
    """An instance of an FMU in continuous-time mode, as a solver sees it."""

    def __init__(self, name, fmi, folder):
        self.made = made(name, fmi)
        path = folder / f"{name}.fmu"
        path.write_bytes(self.made.content)
        description = fmpy.read_model_description(str(path))
        kind = fmpy.fmi3.FMU3Model if fmi == 3 else fmpy.fmi2.FMU2Model
        self.fmi, self.fmu = fmi, kind(
            guid=description.guid, modelIdentifier=description.modelExchange.modelIdentifier,
            unzipDirectory=fmpy.extract(str(path), str(folder / "unpacked")), instanceName="one")  # fmt: skip
        self.references = {each.name: each.valueReference for each in description.modelVariables}
        self.fmu.instantiate()
        if fmi == 2:
            self.fmu.setupExperiment()
        self.fmu.enterInitializationMode()
        self.fmu.exitInitializationMode()
        (self.fmu.updateDiscreteStates if fmi == 3 else self.fmu.newDiscreteStates)()
        self.fmu.enterContinuousTimeMode()
        model = self.made.model
        self.states = [each.name for each in model.carried]
        self.rates = [each.name for each in model.inner if each.vector == "rate"]
        self.outputs = [each.name for each in model.outputs if each.vector == "output"]
        self.inputs = model.inputs

    def put(self, states):
        values = (ctypes.c_double * len(states))(*states)
        self.fmu.setContinuousStates(values, len(states))

    def get(self, names):
        read = self.fmu.getFloat64 if self.fmi == 3 else self.fmu.getReal
        return np.array(read([self.references[name] for name in names]))

    def set(self, name, value):
        (self.fmu.setFloat64 if self.fmi == 3 else self.fmu.setReal)([self.references[name]], [value])

    def jacobian(self, unknowns, knowns):
        """Shape (unknowns, knowns), a column for each direction."""
        rows = [self.references[name] for name in unknowns]
        columns = [self.fmu.getDirectionalDerivative(rows, [self.references[name]], [1.0]) for name in knowns]
        return np.array(columns).T


@pytest.fixture
def solver(tmp_path):
    """A function that makes an instance of the prototype."""
    found = []

    def make(fmi=3, name="prototype"):
        found.append(Solver(name, fmi, tmp_path))
        return found[-1]

    yield make
    for each in found:
        each.fmu.freeInstance()


@pytest.mark.parametrize("fmi", [2, 3])
def test_they_are_differences_of_the_rates(fmi, solver):
    """At a state of the run in which the valve is moving; each state and input is changed by 1e-6 of its scale."""
    one = solver(fmi)
    carried = one.made.model.carried
    states = run_of("prototype", 0.03).final[[each.place for each in carried]]
    unknowns, knowns = [*one.rates, *one.outputs], [*one.states, *one.inputs]
    one.put(states)
    found = one.jacobian(unknowns, knowns)
    starts = {each.name: each for each in one.made.model.settables if each.role == INPUT}
    for column, name in enumerate(knowns):
        ends = []
        size = 1e-6 * (carried[column].kind.scale if name in one.states else max(abs(starts[name].start), 1e-6))
        for sign in (1.0, -1.0):
            if name in one.states:
                one.put(np.where(np.arange(len(states)) == column, states + sign * size, states))
            else:
                one.set(name, starts[name].start + sign * size)
            ends.append(one.get(unknowns))
        one.put(states)
        if name not in one.states:
            one.set(name, starts[name].start)
        slope = (ends[0] - ends[1]) / (2.0 * size)
        largest = np.abs(one.get(unknowns)) / size * 1e-9
        assert np.allclose(found[:, column], slope, rtol=2e-4, atol=largest + 1e-300), name


CASADI = {
    Op.ADD: lambda a, b: a + b, Op.SUBTRACT: lambda a, b: a - b, Op.MULTIPLY: lambda a, b: a * b,
    Op.DIVIDE: lambda a, b: a / b, Op.NEGATIVE: lambda a: -a, Op.ABSOLUTE: casadi.fabs, Op.POWER: lambda a, b: a**b,
    Op.SQRT: casadi.sqrt, Op.EXP: casadi.exp, Op.EXPM1: casadi.expm1, Op.LOG: casadi.log, Op.LOG1P: casadi.log1p,
    Op.SIN: casadi.sin, Op.COS: casadi.cos, Op.TAN: casadi.tan, Op.TANH: casadi.tanh, Op.ATAN: casadi.atan,
    Op.FLOOR: casadi.floor, Op.LESS: lambda a, b: a < b, Op.AT_MOST: lambda a, b: a <= b,
    Op.EQUAL: lambda a, b: a == b, Op.BOTH: casadi.logic_and, Op.EITHER: casadi.logic_or, Op.NOT: casadi.logic_not,
    Op.SELECT: casadi.if_else,
}  # fmt: skip


@cache
def casadi_jacobian(name):
    """CasADi's function of state, command and parameters: derivatives of rates and outputs by state and inputs."""
    tangent, case = made(name, 3).model.tangent, load_system(name).case
    sizes = vectors(case)
    y, u, p = (
        casadi.SX.sym(*each)
        for each in zip("yup", (sizes.state.size, sizes.command.size, sizes.params.size), strict=True)
    )
    nodes = []
    for op, inputs, number in tangent.graph.nodes:
        place = int(number) if op is not Op.CONSTANT else 0
        known = {Op.CONSTANT: number, Op.TIME: 0.0, Op.STATE: y, Op.COMMAND: u, Op.PARAMETER: p}
        if op is Op.SIGNAL:
            nodes.append(p[tangent.signals[place]])
        elif op in known:
            nodes.append(known[op] if op in (Op.CONSTANT, Op.TIME) else known[op][place])
        else:
            nodes.append(CASADI[op](*(nodes[i] for i in inputs)))
    shown = casadi.vertcat(*(nodes[i] for i in tangent.graph.outputs))
    along = casadi.vertcat(y, p[sorted(tangent.inputs)])
    return casadi.Function("jacobian", [y, u, p], [casadi.densify(casadi.jacobian(shown, along))])


@pytest.mark.parametrize("name", ["prototype", "transmission-speed-control"])
def test_they_are_those_of_casadi(name, solver):
    """At 1000 random states, to 1e-10 of the largest in a row.

    CasADi works out both sides of a choice and adds them, so that some of its numbers are none.
    """
    one, model, case = solver(name=name), made(name, 3).model, load_system(name).case
    jacobian, draw = casadi_jacobian(name), np.random.default_rng(3)
    places, first = [each.place for each in model.carried], model.machine.begun.state
    followed = {own.place: each.name for each in model.settables if each.role == INPUT for own in each.followers}
    inputs = [followed[place] for place in sorted(model.tangent.inputs)]
    scales = np.array([each.kind.scale if each.kind else 1.0 for each in model.carried])
    rows = [*places, *(model.tangent.rates + each.place for each in model.outputs if each.vector == "output")]
    command, state = run_of(name, 2 * PERIOD).commands[1], np.array(first, float)
    shares = []
    for _ in range(1000):
        state[places] = first[places] + 0.3 * scales * draw.standard_normal(len(places))
        one.put(state[places])
        found = one.jacobian([*one.rates, *one.outputs], [*one.states, *inputs])
        whole = np.array(jacobian(state, command, vectors(case).params))[rows]
        expected = np.hstack([whole[:, places], whole[:, state.size :]])
        known = np.isfinite(expected)
        size = np.abs(np.where(known, expected, 0.0)).max(axis=1, keepdims=True)
        assert np.isfinite(found).all()
        assert ((np.abs(found - expected) <= 1e-10 * size) | ~known).all()
        shares.append(known.mean())
    assert np.mean(shares) > 0.9


@pytest.mark.thorough
def test_all_shipped_circuits_provide_them():
    for name in (*shipped_systems(), *shipped_systems("practice")):
        system = load_system(name)
        assert trace(system.model, system.case).outputs and trace(system.model, system.case, outputs_part).outputs, name


@pytest.mark.parametrize("fmi", [2, 3])
def test_the_description_names_what_each_rate_depends_on(fmi, solver):
    """All entries of the Jacobian that are not zero are named; the spool speed is all that its angle depends on."""
    one = solver(fmi)
    root = etree.fromstring(made("prototype", fmi).entries["modelDescription.xml"])
    path, key = (".//Derivatives/Unknown", "index") if fmi == 2 else (".//ContinuousStateDerivative", "valueReference")
    named = {int(each.get(key)): set(map(int, each.get("dependencies").split())) for each in root.iterfind(path)}
    assert named[one.references["der(spool.angle)"]] == {one.references["spool.speed"]}
    knowns = [*one.states, *one.inputs]
    found = one.jacobian(one.rates, knowns)
    assert np.count_nonzero(found) > 10
    for row, name in enumerate(one.rates):
        behind = {one.references[known] for known, x in zip(knowns, found[row], strict=True) if x != 0.0}
        assert behind <= named[one.references[name]]
        assert len(named[one.references[name]]) < len(knowns)
