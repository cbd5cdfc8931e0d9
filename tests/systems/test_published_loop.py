"""The closed loop of chapter 5 as the specification has it, in the compiled loop: what of its figures is met, and what
is not. Where nothing else is said the law is told the truth, friction is 0, and figures are rms over whole periods."""

from functools import cache

import numpy as np
import pytest
from tests.systems.axial_texts import (
    HELIX,
    MILD,
    RAW_RATE,
    TABLE,
    TURN,
    backstepping_text,
    change,
    change_table,
    estimation,
    law_of,
    rename,
    report_of,
    rows_from,
    run_of,
    sample_text,
    system_of,
    told_estimate,
    told_sensor,
    told_truth,
    tracking,
    trapezoid_text,
)
from tests.words import wording

from vvdp.base.errors import ParameterError
from vvdp.control.backstepping import best_pressure_weight
from vvdp.control.chamber import volume_compliance
from vvdp.control.storage import estimation_storage, least_estimation_weight, loop_balance
from vvdp.estimation.noise_basis import function_count, write_basis
from vvdp.evaluation.summary import summary
from vvdp.numerics.kalman import covariance_of
from vvdp.programs import axial_numbers, chamber_observer
from vvdp.programs.spool_report import rows_at_samples
from vvdp.sensing.axial_sensor import pollution_at
from vvdp.simulation.run import simulate
from vvdp.systems.system import System, load_system

pytestmark = pytest.mark.heavy

TRAPEZOID = trapezoid_text()
HIGHEST = {"position_max_drive_slide_m": 5.25e-3}
"""What a run has found of the trapezoid."""
MIDDLE = 2.75
"""Position about which sines swing [mm]."""


@pytest.mark.parametrize(
    ("text", "published"),
    [
        (TRAPEZOID, 7.70),
        (backstepping_text(TRAPEZOID, TABLE), 9.16),
        (backstepping_text(TRAPEZOID, MILD), 18.4),
        (backstepping_text(TRAPEZOID, MILD | {"pressure_weight": "5e-13 m^3/Pa"}), 7.45),
    ],
    ids=["passive", "backstepping", "its gains mild", "and lambda_2 right"],
)
def test_trapezoid(text, published):
    """7.61, 9.07, 18.15 and 7.37 um here."""
    assert tracking(text) == pytest.approx(published, rel=0.03)


def aerated(text: str) -> str:
    """30 % of air per oil in the chamber, 10 % in the controller, and a friction that it does not know."""
    text = change_table(text, "oil", air_fraction="23.0769231 %")
    text = change_table(text, "programs.drive.law", friction="0 N*s/m")
    return change_table(text, "components.drive.axial_friction", viscous_friction="20 N*s/m")


def test_air_and_friction_that_the_controller_does_not_know():
    """147 and 156 um here; most of it is the friction, A x' times 20 N s/m."""
    assert tracking(aerated(TRAPEZOID)) == pytest.approx(156.0, rel=0.10)
    assert tracking(aerated(backstepping_text(TRAPEZOID, TABLE))) == pytest.approx(175.0, rel=0.15)


def sine_text(text: str) -> str:
    """1.5 mm at 5 Hz, the velocity low-passed at 1 Hz."""
    duty = f'{{ sine = "{MIDDLE / HELIX:.12g}", amplitude = "{1.5 / HELIX:.12g}", frequency = "5 Hz" }}'
    text = change(text, "operation", duty_ratio=duty)
    text = told_truth(text, TURN)
    return change(text, "run", until="2 s", average_from="1.6 s")


@cache
def compliance() -> float:
    """V/beta in the middle of the sine [m^3/Pa]."""
    drive = law_of(system_of(TRAPEZOID)).drive
    pressure = drive.oil.reference_pressure + (drive.stiffness * MIDDLE * 1e-3 + drive.preload) / drive.area
    return volume_compliance(MIDDLE * 1e-3, pressure, drive)


@pytest.mark.sampled(4)
@pytest.mark.parametrize(
    ("gains", "published", "least"),
    [
        (MILD, 1.62, 10.0),
        (TABLE, 13.3, 10.0),
        (MILD | {"velocity_gain": "38 N*s/m"}, 5.96, 10.0),
        (MILD | {"flow_gain": "1e-10 m^3/(s*Pa)"}, 1.106, 12.0),
    ],
    ids=["k = 0.383", "k = 0.925", "k = 0.832", "k = 0.096"],
)
def test_best_pressure_weight(gains, published, least):
    """The error has its minimum at (V/beta)/(1 - k): steep for a small k, flat for one near 1."""
    system = system_of(backstepping_text(sine_text(TRAPEZOID), gains))
    law = law_of(system)
    predicted = best_pressure_weight(1.0, law.gains, law.gains.flow_gain, law.drive)
    assert predicted == pytest.approx(published, rel=0.01)

    def error(factor):
        weight = f"{factor * compliance():.9g} m^3/Pa"
        return tracking(backstepping_text(sine_text(TRAPEZOID), gains | {"pressure_weight": weight}), 1.0)

    at_best = error(predicted)
    assert at_best < least
    assert error(0.6 * predicted) > 1.5 * at_best
    assert error(1.7 * predicted) > 1.5 * at_best
    if published == 5.96:
        assert predicted * compliance() == pytest.approx(3.0e-12, rel=0.06)


def test_backstepping_at_its_best_is_better_than_the_passivity_law():
    """Not as published, "slightly worse": 135 um against 7 for the gains of the table, 45 against 10 for a lambda_3 of
    1e-10, where the specification has 44 against 52; its sweep steps over the minimum."""
    assert tracking(sine_text(TRAPEZOID), 1.0) == pytest.approx(135.0, rel=0.10)
    slow = change(sine_text(TRAPEZOID), "passivity", flow_gain="1e-10 m^3/(s*Pa)")
    assert tracking(slow, 1.0) == pytest.approx(44.0, rel=0.10)
    weight = f"{1.106 * compliance():.9g} m^3/Pa"
    best = MILD | {"flow_gain": "1e-10 m^3/(s*Pa)", "pressure_weight": weight}
    assert tracking(backstepping_text(sine_text(TRAPEZOID), best), 1.0) < 12.0


@pytest.mark.parametrize("rate", [150, 250])
@pytest.mark.parametrize("friction", [0.0, 8.3, 20.0])
def test_friction_that_the_law_knows(friction, rate):
    """`axial-chamber` with its observer, its reference filtered at so many 1/s: 4.4 to 5.7 um, and passive."""
    settings = [f"parts.drive.viscous_friction={friction} N*s/m", f"parts.drive.filter_rate={rate} 1/s"]
    system = load_system("axial-chamber", settings)
    assert law_of(system).gains.friction == friction
    found = summary(system, simulate(system.model, system.case, system.stepping))
    assert 1e6 * found["spool_position_error_rms_m"] < 10.0
    assert found["storage_rises"] == 0.0


def test_friction_that_each_law_knows():
    """20 N s/m, told the truth: 7.2, 7.3 and 8.5 um by the three laws; 120, 112 and 126 um if they know no friction."""
    rubbed = change(TRAPEZOID, "axial_friction", viscous_friction="20 N*s/m")
    backstepping = backstepping_text(rubbed, TABLE)
    for text in (rubbed, rename(rubbed, "passivity", "printed_passivity"), backstepping):
        unknown = change_table(text, "programs.drive.law", friction="0 N*s/m")
        assert tracking(text) < 10.0
        assert tracking(unknown) > 10.0 * tracking(text)


@pytest.mark.parametrize(("period", "published"), [(0.2, 1.7), (1.0, 7.7), (2.0, 13.5)])
def test_sample_periods_within_the_limit(period, published):
    """1.50, 7.61 and 15.4 um here."""
    assert tracking(sample_text(TRAPEZOID, period)) == pytest.approx(published, rel=0.15)


@pytest.mark.parametrize(("period", "published"), [(3.0, 137.0), (4.0, 512.0)])
def test_sample_periods_beyond_the_limit(period, published):
    """A limit cycle, and told before: 247 and 619 um here, 144 and 518 um with the published feedforward."""
    found = tracking(sample_text(TRAPEZOID, period))
    assert published < found < 2.0 * published
    told = " ".join(system_of(sample_text(TRAPEZOID, period)).extras.warnings(HIGHEST))
    # 2/(788 + 58 1/s): lambda_3 beta/V at 5.25 mm, and lambda_p + K_v/M of the exact feedforward
    assert wording.systems.limit_cycle.format(period=f"{period:g} ms", limit="2.36 ms") in told


@pytest.mark.sampled(2)
@pytest.mark.parametrize(("period", "largest"), [(1.0, 2.6), (2.0, 8.5), (3.0, 19.0), (4.0, 36.0), (5.0, 60.0)])
def test_a_law_that_takes_its_mean_over_the_hold(period, largest):
    """2.49, 8.17, 18.3, 34.4 and 58.2 um, no limit cycle up to 5 ms; at 7 ms there is one, and it is told before."""
    assert tracking(held_text(period)) < largest
    (*told,) = system_of(held_text(period)).extras.warnings(HIGHEST)
    assert wording.systems.will_limit_cycle not in " ".join(told)


def test_sampling_limit_of_a_law_that_takes_its_mean():
    (told,) = system_of(held_text(7.0)).extras.warnings(HIGHEST)
    assert wording.systems.limit_cycle.format(period="7 ms", limit="5.95 ms") in told
    assert tracking(held_text(7.0)) > 150.0


def held_text(period: float) -> str:
    """The trapezoid sampled and held for a period [ms]."""
    return change(sample_text(TRAPEZOID, period), "passivity", flow_hold=f"{period} ms")


@pytest.mark.parametrize("begin", [40.0, 90.0])
def test_the_volume_of_the_chamber_is_learned(begin):
    """60 cc: within 3.3 s to 63 cc, sampled every 1 ms. The offset is that of the sampling: 60.0 cc every 0.2 ms."""
    assert learned_volumes(begin, 1.0)[-1] == pytest.approx(63.3, abs=0.5)
    assert learned_volumes(begin, 0.2)[-1] == pytest.approx(60.0, abs=1.0)


def test_a_volume_is_not_learned_at_rest():
    """The same bits for 0.9 s, white noise of 20 um in the sensor and an observer in the loop."""
    text = change(told_estimate(TRAPEZOID), "operation", duty_ratio=f"{MIDDLE / HELIX:.12g}")
    text = change_table(text, "programs.drive.law", oil_volume="40 cc", volume_gain="3e-5 m^3/Pa")
    _, run = run_of(text)
    assert np.ptp(run.command.drive_law.oil_volume[run.times > 1.2]) == 0.0


def learned_volumes(begin: float, period: float) -> np.ndarray:
    """The volume in a law that begins with so many [cc], at samples of a period [ms], over six trapezoids."""
    text = sample_text(trapezoid_text(periods=6), period)
    held = {"flow_hold": f"{period} ms", "oil_volume": f"{begin} cc", "volume_gain": "3e-5 m^3/Pa"}
    return 1e6 * run_of(change_table(text, "programs.drive.law", **held))[1].command.drive_law.oil_volume


def test_the_run_warns_before_it_limit_cycles():
    """At 2 ms it still tracks; at 1 ms there is nothing to be said. With 1 % of air the same gain takes a fifth."""
    assert not list(system_of(TRAPEZOID).extras.warnings(HIGHEST))
    (told,) = system_of(sample_text(TRAPEZOID, 2.0)).extras.warnings(HIGHEST)
    assert wording.systems.period_above_limit.format(period="2 ms", limit=1.18) in told
    stiff = airy(TRAPEZOID, "0.990099 %")
    (told,) = system_of(sample_text(stiff, 0.4)).extras.warnings(HIGHEST)
    assert "limit" not in told
    assert tracking(sample_text(stiff, 0.4)) < 5.0
    (told,) = system_of(sample_text(stiff, 0.6)).extras.warnings(HIGHEST)
    assert wording.systems.will_limit_cycle in told
    assert tracking(sample_text(stiff, 0.6)) > 100.0


@pytest.mark.thorough
def test_published_feedforward_lacks_what_damps_the_pressure():
    """Without the part of P_d' that the errors make, the pressure's pole is lambda_3 beta/V - 58 1/s: a lambda_3 of
    3e-11 leaves next to nothing of it. At the table's gain the difference is below 1 %."""
    slow = sample_text(change(TRAPEZOID, "passivity", flow_gain="3e-11 m^3/(s*Pa)"), 0.2)
    assert tracking(rename(slow, "passivity", "printed_passivity")) > 5.0 * tracking(slow)
    printed = tracking(rename(TRAPEZOID, "passivity", "printed_passivity"))
    assert tracking(TRAPEZOID) < printed < 1.02 * tracking(TRAPEZOID)


def airy(text: str, air: str) -> str:
    """Another share of air in the oil, which the law knows."""
    return change_table(change_table(text, "oil", air_fraction=air), "parts.drive", air_fraction=air)


def spinning_text(noise: str = "20 um", speed: str = "22.5 rev/s", seed: int = 1) -> str:
    """A constant reference, pollution of 0.2 mm scale, the filter of the specification; it learns at the stop."""
    text = told_estimate(change(TRAPEZOID, "operation", duty_ratio=f"{MIDDLE / HELIX:.12g}", spool_speed=speed))
    text = change(text, "axial_sensor", pollution_scale="0.125 mm", noise=noise, seed=str(seed))
    drifts = {"sensor_deviation": "20 um", "position_drift": "0.1 um", "coefficient_drift": "0.1 um"}
    text = change(text, "axial_observer", coefficient_deviation="0.2 mm", **drifts)
    text = change(text, "axial_sequence", learn_time="0.3 s")
    return change(text, "run", until="3 s", average_from="2 s")


def ripple(text: str) -> float:
    """Peak to peak of the chamber's pressure [bar]."""
    return float(np.ptp(rows_from(text, 1.5).true.pressure)) / 1e5


def mean_over_seeds(number, seeds, **settings) -> float:
    return float(np.mean([number(spinning_text(seed=seed, **settings)) for seed in range(1, seeds + 1)]))


@pytest.mark.parametrize("seeds", [3, pytest.param(20, marks=pytest.mark.slow)])
def test_pollution_of_a_spinning_spool(seeds):
    """46 um and 0.18 bar when the raw signal is fed back: 43.9 um and 0.184 bar here, peak to peak.

    With the filter 1.6 um and 0.014 bar: 3.0 um and 0.030 bar here with white noise of 20 um, which the specification
    does not name, 1.2 um without any.
    """
    raw = mean_over_seeds(lambda text: tracking(told_sensor(text, RAW_RATE), 1.5), seeds)
    assert raw == pytest.approx(46.0, rel=0.15)
    swing = mean_over_seeds(lambda text: ripple(told_sensor(text, RAW_RATE)), seeds)
    assert swing == pytest.approx(0.18, rel=0.15)
    noisy = mean_over_seeds(lambda text: tracking(text, 1.5), seeds)
    assert noisy == pytest.approx(3.0, rel=0.15)
    quiet = mean_over_seeds(lambda text: tracking(text, 1.5), seeds, noise="0 um")
    assert quiet < 1.6 < noisy


def noisy_text(air: str) -> str:
    """No pollution, white noise of 20 um, the raw signal fed back with its slope low-passed at 200 Hz."""
    text = change(TRAPEZOID, "operation", duty_ratio=f"{MIDDLE / HELIX:.12g}")
    text = airy(change(text, "axial_sensor", pollution_scale="0 mm"), air)
    text = told_sensor(text, 200.0 * TURN)
    return change(text, "run", until="3 s", average_from="2 s")


def effort(text: str) -> float:
    return float(np.std(rows_from(text, 1.0).shown.drive))


@pytest.mark.parametrize(
    ("air", "specified"), [("9.0909091 %", 0.0020 / 0.0074), ("39.6244971 %", 0.0164 / 0.0061)], ids=["10 %", "64 %"]
)
def test_which_law_is_more_sensitive_to_noise(air, specified):
    """rms command of backstepping over that of the passivity law, both with the gains of table 5.1: 0.32 with 10 % of
    air, and 2.2 only where V/beta is 3e-12 m^3/Pa."""
    ratio = effort(backstepping_text(noisy_text(air), TABLE)) / effort(noisy_text(air))
    assert ratio == pytest.approx(specified, rel=0.25)


@pytest.mark.slow
def test_a_clock_that_is_half_a_hertz_off():
    """No better than the raw signal, as the text warns: 55 um published, 43 um here. The clock counts 22 Hz."""
    clock = {"angle": "clock.value", "speed": "22 rev/s"}
    product = {"type": "product", "first": "t", "second": "22 rev/s"}
    texts = [spinning_text(seed=100 + seed) for seed in range(20)]
    texts = [
        change_table(change_table(text, "programs.drive.observer", **clock), "programs.clock", **product)
        for text in texts
    ]
    errors = [tracking(text, 1.5) for text in texts]
    assert np.mean(errors) == pytest.approx(43.0, rel=0.15)
    assert np.mean(errors) > 0.8 * 46.0


def unguarded(frequency, speed, harmonics):
    return 1.0


def test_resonance():
    """11.464 rev/s, where the published filter loses the spool: 77 um. As built the pollution is kept as it was learned
    at the stop, and the error stays below 5 um."""
    at_resonance = spinning_text(speed="11.464 rev/s")
    assert tracking(at_resonance, 1.5) < 5.0
    _, run = run_of(at_resonance)
    seen, late = run.command.drive_observer, run.times > 1.5
    assert np.all(seen.frozen[late] == 1.0)
    assert np.max(seen.margin[late]) < 1e-3


@pytest.mark.slow
def test_resonance_without_guard(monkeypatch):
    """Nothing learned at the stop: more than 50 um of the spool and 100 um of the estimate; published 77 um."""
    unlearned = change(spinning_text(speed="11.464 rev/s"), "axial_sequence", learn_time="0 s")
    guarded = tracking(unlearned, 1.5)
    monkeypatch.setattr(chamber_observer, "observability_margin", unguarded)
    seeds = [change(unlearned, "axial_sensor", seed=str(100 + seed)) for seed in range(20)]
    assert np.mean([tracking(text, 1.5) for text in seeds]) > 50.0 > guarded
    assert np.mean([estimation(text, 1.5) for text in seeds]) > 100.0


def resting_text(noise: str, learn: str) -> str:
    """A constant reference, with the shipped pollution and observer."""
    text = change(told_estimate(TRAPEZOID), "operation", duty_ratio=f"{MIDDLE / HELIX:.12g}")
    text = change(change(text, "axial_sensor", noise=noise), "axial_sequence", learn_time=learn)
    return change(text, "run", until="2 s", average_from="1 s")


def polluted_shape(system: System) -> np.ndarray:
    """The coefficients that the observer would have to find."""
    programs = system.circuit.network.programs
    basis, sensor = programs["drive_observer"].settings.observer.pollution.basis, programs["drive_sensor"].settings
    angles = np.linspace(0.0, TURN, 64, endpoint=False)
    rows = np.zeros((angles.size, function_count(basis)))
    for row, angle in zip(rows, angles, strict=True):
        write_basis(angle, basis, row, 0)
    return np.linalg.lstsq(rows, np.array([pollution_at(angle, sensor.near) for angle in angles]), rcond=None)[0]


def storages(text: str) -> tuple[np.ndarray, np.ndarray]:
    """W of the true states [J] and x' P^-1 x of the estimate, at samples from 0.1 s after the start of control on."""
    system, run = run_of(text)
    report, law = report_of(system), law_of(system)
    found = report.run_rows(run)
    late = np.flatnonzero(found.times >= found.times[0] + 0.1)
    believed, shape = run.memory["drive_observer"].filter, polluted_shape(system)
    after = rows_at_samples(run, report.program, report.period)[1]
    estimated = []
    for k in late:
        truth = np.concatenate([[found.true.position[k], found.true.velocity[k]], shape])
        covariance = covariance_of(believed.factors[..., after[k]])
        estimated.append(estimation_storage(truth - believed.mean[..., after[k]], covariance))
    stored = loop_balance(0.0, found.reference, found.true, law.gains, law.drive).storage
    return np.asarray(stored)[late], np.array(estimated)


@pytest.mark.parametrize(("learn", "least"), [("0 s", 0.0683), ("0.3 s", 0.0250)])
def test_lyapunov_function_of_the_loop_with_its_observer(learn, least):
    """Section 5.6 with a weight: what the loop stores rises at hundreds of samples, what the estimate errs by never
    does, and W + c x' P^-1 x falls throughout from c = 0.068 J on; 0.025 J where the pollution has been learned."""
    stored, estimated = storages(resting_text("0 um", learn))
    assert np.count_nonzero(np.diff(stored) > 0.0) > 500
    assert np.all(np.diff(estimated) < 0.0)
    weight = least_estimation_weight(stored, estimated)
    assert weight == pytest.approx(least, rel=0.1)
    assert np.all(np.diff(stored + 1.001 * weight * estimated) <= 0.0)
    assert np.any(np.diff(stored + 0.9 * weight * estimated) > 0.0)


def test_no_weight_makes_a_noisy_estimate_fall():
    """White noise moves the estimate either way at every sample: the function is one of the loop without noise."""
    stored, estimated = storages(resting_text("20 um", "0.3 s"))
    with pytest.raises(ParameterError, match=wording.systems.no_weight):
        least_estimation_weight(stored, estimated)


def test_rows_too_far_apart_tell_nothing():
    """What is commanded at a sample stands in the row of the next one: a millisecond later, at five samples in one."""
    coarse = change(sample_text(TRAPEZOID, 0.2), "run", record_interval="1 ms")
    assert rows_from(coarse, 0.6).times.size < 2500
    assert rows_from(coarse, 0.6).times[0] > 1.6


def test_what_the_spool_gives_is_no_rise(monkeypatch):
    """Friction that the law does not know holds the spool back, and the chamber stores what that leaves over: no rise,
    though nothing is put down to an estimate. The other way round it would be one at thousands of samples."""
    monkeypatch.setattr(axial_numbers, "EXPLAINED", 0.0)
    text = change_table(sample_text(TRAPEZOID, 0.2), "components.drive.axial_friction", viscous_friction="20 N*s/m")
    found = axial_numbers.storage_numbers(rows_from(text, 0.2), law_of(run_of(text)[0]), 0.2e-3)
    assert found["storage_rises"] == 0.0
    assert found["storage_largest_J"] == pytest.approx(1.23e-5, rel=0.05)
