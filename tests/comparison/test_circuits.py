"""Rival circuits side by side: powers in closed form, conservation, quadrants, and rows that were measured before."""

from dataclasses import replace

import numpy as np
import pytest
from tests.words import wording

from vvdp.base.errors import ConfigError, ParameterError, RunError
from vvdp.comparison.circuit_result import LOST, circuit_result, screen_tables
from vvdp.comparison.circuit_trials import compare_circuits, run_pair
from vvdp.control.duty_cycle import DutyCycle
from vvdp.fluid.mixture import fluid_state
from vvdp.machines.duties import known_cylinder, read_duty, shipped_duties, sized_duty
from vvdp.report.plot import new_figure
from vvdp.results.result import Grade
from vvdp.rivals.rival_account import begin_of, common_reference, refuse_unled, system_for
from vvdp.rivals.rival_circuits import (
    CIRCUITS,
    LEAKAGE,
    METERING,
    RELIEF,
    RETURN,
    SINKS,
    SWITCHING,
    machine_with_valve,
)
from vvdp.simulation.run import simulate
from vvdp.studies.engine import ThisProcess
from vvdp.systems.system import load_system

pytestmark = pytest.mark.thorough

A, B = 20.26e-4, 10.77e-4
"""Areas of the cylinder [m^2]."""
FRICTION = 2000.0
"""Viscous friction of the rod [N s/m]."""
VALVE = 1e-6
"""Conductance of a valve at the cylinder, fully open [m^3/(s Pa^0.5)]."""
LEAKAGE_CONDUCTANCE = 2e-12
"""Of every pump [m^3/(s Pa)]."""


def circuit(name):
    return next(each for each in CIRCUITS if each.name == name)


def duty(name):
    return next(each for each in shipped_duties() if each.name == name)


def sink(score, which):
    return score.sinks[SINKS.index(which)]


RIVALS = tuple(each for each in CIRCUITS if each.begin is None)
"""All but the whole machine, which takes ten times as long as all others."""


@pytest.fixture(scope="module")
def found():
    """All rivals on all shipped cycles."""
    return compare_circuits(shipped_duties(), RIVALS)


@pytest.fixture(scope="module")
def machines():
    """The whole machine on all shipped cycles of one cylinder; several are as many machines."""
    return compare_circuits(
        [each for each in shipped_duties() if not each.further], [each for each in CIRCUITS if each not in RIVALS]
    )


@pytest.fixture(scope="module")
def steady():
    """A ramp long enough to be steady: 10 cm/s against 4 kN out, and driven by it back."""
    cycle = DutyCycle(times=(0.0, 2.0, 4.0), positions=(0.05, 0.25, 0.05), forces=(-4e3,) * 3)
    return replace(duty("triangle"), name="steady", cycle=cycle)


def course(name, steady):
    """A run on the steady ramp, with the rows in the middle of going out and coming back in its last round."""
    system = system_for(circuit(name), steady)
    run = simulate(system.model, system.case, system.stepping)
    since = run.times - 2.0 * steady.period
    return run, (since > 1.2) & (since < 1.8), (since > 3.2) & (since < 3.8)


def power(run, book, rows):
    """Mean power of a book over rows [W]."""
    times, values = run.times[rows], getattr(run.state.books.supplied, book)[rows]
    return (values[-1] - values[0]) / (times[-1] - times[0])


# Powers in closed form at a steady load


@pytest.mark.parametrize("name", ["throttle", "flow-control-unit"])
def test_a_fixed_pump_gives_its_flow_at_the_pressure_of_the_relief_valve(name, steady):
    """Q h(P), P = 60 bar + 5 bar Q_r/40 lpm, Q_r = Q - A v - G P; oil that gives way takes a little less than Q P.
    A digital flow control unit is a throttle like another."""
    run, out, back = course(name, steady)
    oil = load_system("throttle-control").circuit.network.oil
    flow = 40.0 / 60e3
    for rows, taken in ((out, A * 0.1), (back, B * 0.1)):
        level = (60e5 + 5e5 * (1.0 - taken / flow)) / (1.0 + 5e5 * LEAKAGE_CONDUCTANCE / flow)
        expected = flow * fluid_state(level + oil.reference_pressure, oil).enthalpy
        assert power(run, "pump_shaft", rows) == pytest.approx(expected, rel=5e-3)
        assert expected == pytest.approx(level * flow, rel=0.02)


def test_an_ideal_pump_gives_what_rod_and_return_ask_for(steady):
    """(A_s v + G P_s) P_s with P_s A_s = F + b v + P_r A_r, P_r = (A_r v/(K u))^2, u as the loop commands it."""
    run, out, back = course("ideal-pump", steady)
    for rows, sign, into, returned in ((out, 1.0, A, B), (back, -1.0, B, A)):
        u = np.mean(run.command.loop.opening[rows])
        behind = (returned * 0.1) ** 2 * (1.0 / (steady.return_conductance * u) ** 2 + 1.0 / VALVE**2)
        level = (sign * 4e3 + FRICTION * 0.1 + behind * returned) / into + (into * 0.1 / VALVE) ** 2
        expected = (into * 0.1 + LEAKAGE_CONDUCTANCE * level) * level
        assert power(run, "pump", rows) == pytest.approx(expected, rel=1e-2)


def test_a_pump_over_centre_gives_the_force_times_the_velocity_either_way(steady):
    """Out (F + b v) v and back (F - b v) v, with what the low side does and what leaks at the difference."""
    run, out, back = course("four-valves", steady)
    for rows, sign in ((out, 1.0), (back, -1.0)):
        low = 2e5 + sign * (B * 0.1 / VALVE) ** 2
        rise = (4e3 + sign * FRICTION * 0.1 + low * B) / A + sign * (A * 0.1 / VALVE) ** 2 - 2e5
        expected = (sign * A * 0.1 + LEAKAGE_CONDUCTANCE * rise) * rise
        assert power(run, "pump", rows) == pytest.approx(expected, rel=1e-2)
    for name in ("shuttle", "pilot-checks"):
        run, out, back = course(name, steady)
        for rows, sign in ((out, 1.0), (back, -1.0)):
            low = np.mean(run.state.chamber_b[rows]) - 101325.0
            rise = (4e3 + sign * FRICTION * 0.1 + low * B) / A - low
            expected = (sign * A * 0.1 + LEAKAGE_CONDUCTANCE * rise) * rise
            assert power(run, "pump", rows) == pytest.approx(expected, rel=2e-2)


@pytest.mark.parametrize("name", ["vvdp", "vvdp-slow", "vvdp-following", "load-sensing", "linear-valves"])
def test_the_meter_out_throttle_opens_by_one_law_in_every_circuit(name, steady):
    """Back, 4 kN less 200 N of friction: P_r = (6 bar 10.77 + 3.8 kN)/20.26 cm^2 = 21.95 bar, and
    u = 20.26 cm^2 v/(3e-7 root P_r) = 0.456 at v = 0.1 m/s, with 10 1/s times how far the rod is ahead."""
    wide = replace(steady, return_conductance=3e-7)
    each, begin = circuit(name), begin_of(circuit(name), wide)
    system = system_for(each, wide, begin)
    run = simulate(system.model, system.case, system.stepping)
    since = run.times - begin - 2.0 * steady.period
    rows = (since > 3.2) & (since < 3.8)
    late = run.state.rod.position - common_reference(wide.cycle, run.times - begin)
    asked = 0.1 + 10.0 * np.mean(late[rows])
    opening = np.mean(getattr(run.command, each.program).opening[rows])
    assert opening == pytest.approx(0.456 * asked / 0.1, rel=0.015)
    assert asked == pytest.approx(0.1, rel=0.05)


# What was measured before, by another program


def test_throttle_control_is_as_measured_on_the_triangle():
    """Pump 4238, relief 3622, valve 296 + 221, friction 5.6, positive actuator 29.0 W."""
    score = run_pair(circuit("throttle"), duty("triangle")).score
    assert score.drawn == pytest.approx(4238.0, rel=2e-3)
    assert sink(score, RELIEF) == pytest.approx(3622.0, rel=5e-3)
    assert sink(score, METERING) == pytest.approx(517.0, rel=5e-3)
    assert (score.friction, score.delivered) == pytest.approx((5.6, 29.0), abs=0.1)
    assert sink(score, LEAKAGE) == pytest.approx(2e-12 * 64.4e5**2, rel=0.02)


def test_throttle_control_is_as_measured_under_the_heavy_load():
    """Pump 7431, relief 4389, valve 1080 + 1622, friction 52, positive actuator 812 W."""
    score = run_pair(circuit("throttle"), duty("heavy")).score
    assert score.drawn == pytest.approx(7431.0, rel=2e-3)
    assert sink(score, RELIEF) == pytest.approx(4389.0, rel=1e-2)
    assert sink(score, METERING) == pytest.approx(2702.0, rel=1e-2)
    assert (score.friction, score.delivered) == pytest.approx((52.0, 812.0), rel=1e-2)


def test_the_ideal_pump_is_as_measured_on_the_triangle():
    """93 W, of which 87 W over the return; the loop is another one, and follows the reversals less hastily."""
    score = run_pair(circuit("ideal-pump"), duty("triangle")).score
    assert score.drawn == pytest.approx(93.0, rel=0.08)
    assert sink(score, RETURN) == pytest.approx(87.0, rel=0.12)


# Laws


def closes(run):
    """Whether both balances of a run close, and its account with them."""
    score = run.score
    assert max(abs(score.energy_residual), abs(score.mass_residual)) < 1e-7, run[:2]
    out = score.returned + score.delivered + sum(score.sinks) + score.stored
    assert score.drawn + score.received == pytest.approx(out, rel=2e-5), run[:2]  # codes ripple between rows
    assert min(score.drawn, score.returned, *score.sinks) >= 0.0
    return True


def test_nothing_is_lost_in_any_circuit(found):
    assert len(found.found) == len(RIVALS) * len(shipped_duties()) and found.finished
    assert all(map(closes, found.found))


@pytest.mark.slow
def test_the_whole_machine_is_as_measured(machines):
    """By its own laws 1455 W with its supply supported, a third of throttle control's; 3356 W under the heavy load."""
    assert all(map(closes, machines.found))
    triangle, heavy = (machines.score(name, "vvdp-chapter-6") for name in ("triangle", "heavy"))
    assert triangle.drawn == pytest.approx(1455.0, rel=0.01)
    assert sink(triangle, RELIEF) == pytest.approx(363.0, rel=0.05)
    assert sink(triangle, SWITCHING) == pytest.approx(370.0 + 581.0, rel=0.05)
    assert (triangle.friction, triangle.delivered) == pytest.approx((5.5, 28.7), abs=0.2)
    assert heavy.drawn == pytest.approx(3356.0, rel=0.04)
    assert sink(heavy, RETURN) == pytest.approx(1569.0, rel=0.03)
    slow = machines.score("triangle", "vvdp-slow")
    assert slow.drawn == pytest.approx(687.0 + 26.0, rel=0.08)  # by its own laws
    for run in machines.found:
        assert run.score.returned < 1e-6 and run.score.pressure_min > -1e5, run[:2]


@pytest.mark.slow
def test_the_law_of_the_return_is_what_the_machine_of_chapter_6_draws_more(machines):
    """Under the heavy load the loss over the throttle falls by 0.63 kW with the common law, as does what is drawn."""
    common, published = (machines.score("heavy", name) for name in ("vvdp", "vvdp-chapter-6"))
    saved = sink(published, RETURN) - sink(common, RETURN)
    assert saved == pytest.approx(630.0, rel=0.05)
    assert published.drawn - common.drawn == pytest.approx(saved, rel=0.1)


def test_the_digging_cycle_goes_through_all_four_quadrants():
    cycle = duty("digging").cycle
    moves = zip(np.diff(cycle.positions), np.array(cycle.forces[:-1]) + np.diff(cycle.forces) / 2.0, strict=True)
    assert {(np.sign(moved), np.sign(force)) for moved, force in moves if moved and force} == {
        (1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)
    }  # fmt: skip


def test_all_quadrants_are_followed_and_the_low_side_is_held(found):
    """The rod stays within a centimetre while the load changes sides, and no low side falls 2 bar below its charge.
    Within two where pulses fill a line with an accumulator, which no flow map makes up for."""
    for run in found.found:
        assert run.score.tracking_max < (0.02 if run.circuit == "linear-valves" else 0.01), run[:2]
        assert not run.score.pressure_min < run.score.charge - 2e5, run[:2]


def test_a_load_that_overruns_drives_the_pumps_that_can_be_driven(found):
    for name in ("heavy", "digging"):
        given = {run.circuit: run.score.returned / run.score.received for run in found.found if run.duty == name}
        assert given["throttle"] == given["ideal-pump"] == 0.0
        assert min(given[each] for each in ("shuttle", "pilot-checks", "four-valves")) > 0.8, name


# Cycles


def test_a_cycle_is_sized_by_one_rule():
    """10 kN and 346 N of friction on 20.26 cm^2 are 51.1 bar: 110 bar. 3.5e-4 m^3/s back at 13 bar and 0.8: 3.84e-7."""
    heavy = duty("heavy")
    found = sized_duty("heavy", "", "", heavy.cycle, *known_cylinder())
    assert found.relief_pressure == heavy.relief_pressure == 110e5
    assert found.return_conductance == pytest.approx(A * 0.1728 / (0.8 * np.sqrt(13e5)), rel=1e-9)
    triangle = duty("triangle")
    found = sized_duty("triangle", "", "", triangle.cycle, *known_cylinder())
    assert found.relief_pressure == triangle.relief_pressure == 60e5
    assert found.return_conductance == pytest.approx(triangle.return_conductance, rel=1e-2)


def test_a_cycle_of_ones_own_is_read(tmp_path):
    file = tmp_path / "mine.csv"
    file.write_text("time, force ,position\n1,-500,0.05\n3,-500,0.15\n\n5,-400,0.05\n")
    found = read_duty(file, *known_cylinder())
    assert (found.name, found.period, found.relief_pressure) == ("mine", 4.0, 60e5)
    assert found.cycle.positions == (0.05, 0.15, 0.05) and found.cycle.forces == (-500.0, -500.0, -400.0)
    assert found.load == wording.compare.own_load.format(low=-0.5, high=-0.4)
    score = compare_circuits([found], [circuit("throttle")]).score("mine", "throttle")
    assert score.tracking_max < 1e-3


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("", wording.compare.column_missing.format(column="time")),
        ("time,position\n0,0.1\n", wording.compare.column_missing.format(column="force")),
        ("time,position,force\n0,0.1,0\n1,ten,0\n", "mine.csv:3: '1,ten,0' " + wording.compare.not_three_numbers),
        ("time,position,force\n0,0.1,0\n1,0.1\n", "mine.csv:3: '1,0.1,' " + wording.compare.not_three_numbers),
        ("time,position,force\n0,0.1,0\n", wording.compare.rows_missing.format(count=1)),
        (
            "time,position,force\n0,0.1,0\n2,0.2,0\n2,0.1,0\n",
            wording.compare.time_stands.format(row=3, time="2000 ms", before="row 2, 2000 ms"),
        ),
        (
            "time,position,force\n0,0.1,0\n2,0.2,0\n",
            wording.compare.does_not_return.format(row=2, position="200 mm", first="100 mm"),
        ),
    ],
)
def test_a_file_that_is_no_cycle_is_refused_with_its_line(tmp_path, text, told):
    file = tmp_path / "mine.csv"
    file.write_text(text)
    with pytest.raises(ConfigError, match=told):
        read_duty(file, *known_cylinder())


def test_a_file_that_is_none_is_refused(tmp_path):
    with pytest.raises(ConfigError, match=wording.files.cannot_read):
        read_duty(tmp_path / "none.csv", *known_cylinder())


@pytest.mark.parametrize(
    ("positions", "told"),
    [
        (
            (0.05, 0.35, 0.05),
            "throttle on steady: programs.loop.positions: "
            + wording.compare.rod_travels.format(row=2, position="350 mm", low=0, high=300),
        ),
        ((0.05, 0.29, 0.05), wording.compare.too_fast.format(row=2, speed="480 mm/s", reach="329.1 mm/s")),
    ],
)
def test_what_no_circuit_can_follow_is_refused_before_any_run(steady, positions, told):
    cycle = replace(steady.cycle, times=(0.0, 0.5, 1.0), positions=positions)
    with pytest.raises(ParameterError, match=told):
        compare_circuits([replace(steady, cycle=cycle)], RIVALS)


# The comparison


def test_an_interrupted_comparison_keeps_what_is_done():
    def stop(done, total):
        if done >= 1:
            raise KeyboardInterrupt

    found = compare_circuits(shipped_duties()[1:2], RIVALS, engine=ThisProcess(1), progress=stop)
    assert not found.finished and 1 <= found.runs < len(RIVALS)
    assert wording.progress.incomplete_page in {each.title for each in circuit_result(found).findings}
    with pytest.raises(KeyboardInterrupt):
        compare_circuits(shipped_duties()[1:2], RIVALS, progress=lambda done, total: stop(1, total))


def test_a_comparison_interrupted_while_it_is_tuned_names_what_is_left():
    """Two of three are at the common error at most: the third is named, and no error is claimed for all."""
    circuits = [circuit(name) for name in ("ideal-pump", "shuttle", "pilot-checks")]

    def stop(done, total):
        if done > len(circuits):
            raise KeyboardInterrupt

    found = compare_circuits(shipped_duties()[:1], circuits, engine=ThisProcess(1), progress=stop)
    assert found.error is None and not found.finished and found.runs == 3
    assert 1 <= len(found.untuned) < 3 and found.missing[-1] == "pilot-checks on triangle at the common error"
    (told,) = [each.text for each in circuit_result(found).findings if each.title == wording.progress.incomplete_page]
    assert told.startswith(f"3 of 3 runs were made, {3 - len(found.untuned)} of them at the common error")


def test_nothing_to_compare_is_refused():
    with pytest.raises(ParameterError, match=wording.compare.nothing_to_compare.format(cycles=0, circuits=len(RIVALS))):
        compare_circuits([], RIVALS)


def test_a_run_whose_control_is_left_is_no_run(steady):
    system = system_for(circuit("throttle"), steady)
    run = simulate(system.model, system.case, system.stepping)
    refuse_unled(circuit("throttle"), system, steady, run)
    longer = replace(steady, cycle=replace(steady.cycle, positions=(0.05, 0.5, 0.05)))
    with pytest.raises(RunError, match=wording.compare.reference_went_through + " .* of 450 mm"):
        refuse_unled(circuit("throttle"), system, longer, run)


def test_another_valve_is_that_of_the_machine():
    wider = machine_with_valve("prototype")
    systems = system_for(wider, duty("triangle")), load_system("prototype")
    machine, prototype = (each.circuit.network.parts["valve"].values[0] for each in systems)
    assert machine == prototype
    with pytest.raises(ConfigError, match=wording.compare.not_one_valve):
        machine_with_valve("throttle-control")


def test_each_statement_names_its_load(found):
    result = circuit_result(found)
    for each in shipped_duties():
        (told,) = [f.text for f in result.findings if f.text.lower().startswith(f"{each.name} ({each.load})".lower())]
        assert all(f"{other.name} " in told for other in RIVALS)
    off = [f for f in result.findings if f.grade is Grade.WARNING]
    named = [f.text.partition(" is off")[0] for f in off]
    assert named == [f"{run.circuit} on {run.duty}" for run in found.found if run.score.tracking_max > LOST]
    assert {"bleed-off on heavy", "linear-valves on heavy", "four-valves on digging"} < set(named)


def test_shares_are_those_of_all_that_came_in(found):
    shares = circuit_result(found).tables["shares"]
    keys = [key for key in shares.columns if key.startswith("share_")]
    total = sum(np.asarray(shares[key], float) for key in keys)
    stored = [run.score.stored / (run.score.drawn + run.score.received) for run in found.found]
    assert total + stored == pytest.approx(1.0, abs=2e-5)


def test_bars_follow_one_another(found):
    """The parts of a bar begin where those before end, and are as long in all as what came in."""
    result = circuit_result(found)
    (axes,) = new_figure(result.charts["powers-heavy"], result.tables).axes
    last = [sorted((bar for bar in axes.patches if abs(bar.get_y() + 0.325 - row) < 0.1), key=lambda b: b.get_x())
            for row in range(len(RIVALS))]  # fmt: skip
    for row, bars in enumerate(last):
        ends = [bar.get_x() + bar.get_width() for bar in bars]
        assert [bar.get_x() for bar in bars[1:]] == pytest.approx(ends[:-1])
        score = found.score("heavy", RIVALS[len(RIVALS) - 1 - row].name)
        assert ends[-1] == pytest.approx(score.drawn + score.received - score.stored, rel=1e-3)


def test_screen_leaves_out_what_none_loses(found):
    """Only a measured pump has friction here."""
    fewer = replace(
        found,
        circuits={name: each for name, each in found.circuits.items() if not each.measured},
        found=tuple(run for run in found.found if not found.circuits[run.circuit].measured),
    )
    for each, has_friction in ((found, True), (fewer, False)):
        shown = screen_tables(each, circuit_result(each))["triangle"].shown
        assert ("loss_pump_friction_W" in shown) is has_friction and "loss_relief_W" in shown
