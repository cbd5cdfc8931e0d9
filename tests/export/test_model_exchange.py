"""FMUs for model exchange, integrated by CVode of FMPy: as near to a run of vvdp as the tolerance allows."""

from dataclasses import replace

import fmpy
import fmpy.fmi3
import fmpy.validation as validation
import numpy as np
import pytest
from tests.export import builds
from tests.export.fmi_host import OK, Host
from tests.export.test_fmu import PERIOD, paths_of, pytestmark, run_of
from tests.generator.c_way import compilers

from vvdp.base.errors import ConfigError
from vvdp.export.fmu import require_kind
from vvdp.export.fmu_binary import compile_binary
from vvdp.export.fmu_model import Guest
from vvdp.export.fmu_sources import source_files
from vvdp.programs.foreign.platforms import this_platform
from vvdp.simulation.run import simulate
from vvdp.systems.system import load_system, shipped_systems

__all__ = ["pytestmark"]


def made(name, fmi):
    return builds.made(name, fmi, guest=Guest())


@pytest.fixture
def path(tmp_path):
    """A function that writes the FMU of a system."""

    def write(name, fmi):
        file = tmp_path / f"{name}-{fmi}.fmu"
        file.write_bytes(made(name, fmi).content)
        return str(file)

    return write


@pytest.fixture
def component(path, tmp_path):
    """An instance of the prototype for model exchange, FMI 3, before its initialisation."""
    file = path("prototype", 3)
    description = fmpy.read_model_description(file)
    found = fmpy.fmi3.FMU3Model(
        guid=description.guid,
        modelIdentifier=description.modelExchange.modelIdentifier,
        unzipDirectory=fmpy.extract(file, str(tmp_path / "unpacked")),
        instanceName="one",
    )
    found.instantiate()
    found.references = {each.name: each.valueReference for each in description.modelVariables}
    yield found
    found.freeInstance()


def carried(file, until, tolerance, output_interval=PERIOD, **others):
    return fmpy.simulate_fmu(
        file,
        fmi_type="ModelExchange",
        stop_time=until,
        output_interval=output_interval,
        relative_tolerance=tolerance,
        **others,
    )


@pytest.mark.parametrize("fmi", [2, 3])
def test_cvode_comes_to_the_run(fmi, path):
    """Half a second of the prototype: 35 PWM periods with all their edges."""
    file = path("prototype", fmi)
    assert validation.validate_fmu(file) == []
    run = run_of("prototype", 0.5)
    angle = run.states[:, paths_of(load_system("prototype")).index("spool.angle")]
    for tolerance, most in ((1e-5, 1e-2), (1e-7, 3e-4)):
        found = carried(file, 0.5, tolerance)
        on_grid = np.interp(np.arange(501) * PERIOD, found["time"], found["spool.angle"])
        assert np.max(np.abs(on_grid - angle)) < most
        assert len(found) - 501 < 2000


def test_an_ideal_relief_valve_lets_no_higher_pressure_pass(path):
    run = run_of("prototype", 0.2, ['relief_valve.override_pressure="0 bar"'])
    highest = run.states[:, paths_of(load_system("prototype")).index("inlet")].max()
    found = carried(path("prototype", 3), 0.2, 1e-7, start_values={"relief_valve.override_pressure": 0.0})
    assert found["inlet"].max() == pytest.approx(highest, rel=1e-2)


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("name", "fmi"),
    [
        *((name, 3) for name in (*shipped_systems(), *shipped_systems("practice"))),
        ("two-cylinders", 2),
        ("long-hose", 2),
    ],
)
def test_every_system_runs_in_both_kinds(name, fmi, path, tmp_path):
    """Over a hundred samples: by its own loop to the bit, by CVode to 1e-3 of each state's largest or nominal value.

    At the end, for a row may be interpolated a hair behind a jump.
    """
    system = load_system(name)
    period = system.stepping.sample_period
    until = 100 * period
    stepping = replace(system.stepping, until=until, record_interval=period, window=0.0, average_from=None)
    run = simulate(system.model, system.case, stepping)
    host = Host(made(name, fmi), tmp_path / "host")
    assert host.begin() == OK, host.said
    for _ in range(100):
        assert host.step(period) == OK, host.said
    paths = paths_of(system)
    assert host.get(*paths).tobytes() == run.final[: len(paths)].tobytes()
    shown = [each for each in made(name, fmi).model.outputs if each.vector == "state"]
    names = [each.name for each in shown]
    found = carried(path(name, fmi), until, 1e-7, output=names, output_interval=period)
    for each in shown:
        size = max(each.kind.scale if each.kind else 1.0, np.max(np.abs(run.states[:, each.place])))
        assert abs(found[each.name][-1] - run.final[each.place]) < 1e-3 * size, each.name


def test_rates_are_those_of_the_states(component):
    """The pump turns at 1800 rpm; the speed of the spool is the rate of its angle; indicators are positive at rest."""
    component.enterInitializationMode()
    component.exitInitializationMode()
    *_, is_known, first = component.updateDiscreteStates()
    assert is_known and first == PERIOD
    names = ["der(pump_shaft)", "der(spool.angle)", "spool.speed", "event_indicator[1]"]
    pump, angle, speed, indicator = component.getFloat64([component.references[name] for name in names])
    assert pump == pytest.approx(1800 * 2 * np.pi / 60, rel=1e-15)
    assert angle == speed
    assert indicator > 0.0


def test_states_that_cannot_be_are_refused(component):
    component.enterInitializationMode()
    component.exitInitializationMode()
    count = len(made("prototype", 3).model.carried)
    states = np.zeros(count)
    states[0] = np.nan
    with pytest.raises(Exception, match="error"):
        set_states(component, states)
    with pytest.raises(Exception, match="error"):
        set_states(component, np.ones(count - 1))
    set_states(component, np.full(count, 1e5))
    component.completedIntegratorStep()
    set_states(component, np.full(count, -1e5))
    with pytest.raises(Exception, match="error"):
        component.completedIntegratorStep()


def set_states(component, states):
    values = (fmpy.fmi3.fmi3Float64 * len(states))(*states)
    component.setContinuousStates(values, len(states))


def test_what_is_no_guest_cannot_be_carried():
    with pytest.raises(ConfigError, match="expected cs, me, both"):
        require_kind("se")
    require_kind("both")


def test_books_are_carried_where_they_are_asked_for():
    without, whole = (builds.model_of("accumulator-charging", guest=Guest(has_books)) for has_books in (False, True))
    more = {each.key for each in whole.carried} - {each.key for each in without.carried}
    assert more and all(each.startswith("books.") for each in more)
    assert len(whole.carried) == whole.machine.begun.state.size


@pytest.mark.parametrize("fmi", [2, 3])
def test_the_sources_of_a_guest_have_no_warning(fmi, monkeypatch):
    model = made("accumulator-charging", fmi).model
    warnings = ("-Wall", "-Wextra", "-pedantic", "-Wshadow", "-Wconversion", "-Werror")
    sources, flags = source_files(model, fmi, "{x}"), (*model.machine.flags, *warnings)
    for compiler in compilers():
        monkeypatch.setenv("CC", compiler)
        assert compile_binary(sources, flags, this_platform())[1]
