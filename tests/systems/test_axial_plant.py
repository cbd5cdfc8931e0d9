"""What moves in a system is read from its circuit as it is written, wherever it stands and whatever acts on it."""

import numpy as np
import pytest
from tests.words import wording

from vvdp.base.errors import ConfigError
from vvdp.evaluation.axial_plant import AxialPlant, AxialSight, axial_plant, axial_sight
from vvdp.fluid.mixture import fluid_state
from vvdp.systems.system import load_system

SPOOL = """
[nodes]
tank = { type = "tank" }
chamber = { type = "volume", volume = "60 cc", start = "3 bar" }
slide = { type = "rod", position = "-1 mm" }
spool = { type = "driven-shaft", speed = "22.5 rev/s" }
[components.piston]
type = "plunger"
a = "chamber"
rod = "slide"
area_a = "174 mm^2"
moving_mass = "0.5 kg"
[components.spring]
type = "spring"
rod = "slide"
stiffness = "2594 N/m"
preload = "211.5 N"
rest_position = "0 mm"
[components.friction]
type = "rod-friction"
rod = "slide"
viscous_friction = "20 N*s/m"
coulomb_friction = "2 N"
breakaway_friction = "5 N"
stribeck_velocity = "20 mm/s"
coulomb_velocity = "1 mm/s"
[components.stops]
type = "end-stop"
rod = "slide"
lower_end = "-1 mm"
upper_end = "6 mm"
stop_stiffness = "1e7 N/m"
stop_damping = "10 s/m"
[components.feed]
type = "orifice"
a = "chamber"
b = "tank"
area = "1 mm^2"
discharge_coefficient = 0.62
transition_pressure = "0.05 bar"
[components.bearing]
type = "shaft-friction"
shaft = "spool"
shaft_damping = "0.001 N*m*s"
coulomb_torque = "0 N*m"
coulomb_speed = "1 rad/s"
[run]
until = "10 ms"
"""
SECOND = '[components.weight]\ntype = "weight"\nrod = "slide"\nmass = "1.5 kg"\nslope = "0 deg"\n'


def spool(folder, text=SPOOL):
    (folder / "spool.toml").write_text(text)
    return load_system(str(folder / "spool.toml"))


def test_plant_of_a_drawn_spool(tmp_path):
    """It starts in its stop, with too little pressure: neither is the plant."""
    system = spool(tmp_path)
    found = axial_plant(system)
    assert found.name == "slide"
    assert found.plant == pytest.approx((0.5, 2594.0, 20.0), rel=1e-6)
    assert axial_sight(system) == AxialSight()


def test_plants_of_the_axial_drives():
    """As their files have them; the gerotor's spool follows a flow. Each is what its sensor sees."""
    chamber, gerotor = load_system("axial-chamber"), load_system("axial-gerotor")
    assert axial_plant(chamber).plant == pytest.approx((0.5, 2594.0, 8.3), rel=1e-9)
    assert axial_plant(gerotor) == AxialPlant("drive_gerotor", None)
    turn = 2.0 * np.pi
    assert axial_sight(chamber) == ("drive_slide", pytest.approx(22.5 * turn), 5)
    assert axial_sight(gerotor) == ("drive_gerotor", pytest.approx(10.0 * turn), 5)


def test_oil_is_as_stiff_as_beta_a2_over_v_says(tmp_path):
    """At 2.5 mm: 211.5 N + 2594 N/m 2.5 mm over 174 mm^2 is 12.53 bar gauge; V = 60 cc + 0.435 cc."""
    system = spool(tmp_path)
    found = axial_plant(system)
    area = 174e-6
    pressure = 101325.0 + (211.5 + 2594.0 * 2.5e-3) / area
    modulus = fluid_state(pressure, system.circuit.network.oil).bulk_modulus
    assert found.chambers == ("chamber",)
    assert found.oil_stiffnesses == pytest.approx((area**2 * modulus / (60e-6 + area * 2.5e-3),), rel=1e-5)


def test_all_that_moves_counts(tmp_path):
    assert axial_plant(spool(tmp_path, SPOOL + SECOND)).plant.mass == 2.0


def test_two_chambers_and_no_spring():
    found = axial_plant(load_system("cylinder-stops"))
    assert found.plant == pytest.approx((305.0, 0.0, 1000.0), rel=1e-6)
    assert found.chambers == ("chamber_a", "chamber_b")
    assert all(stiffness > 0.0 for stiffness in found.oil_stiffnesses)


def test_what_does_not_move_is_refused():
    with pytest.raises(ConfigError, match="prototype: " + wording.observability.needs_axis):
        axial_plant(load_system("prototype"))


def test_another_name_is_refused(tmp_path):
    with pytest.raises(ConfigError, match=wording.observability.none_of_these.format(part="spool", parts="slide")):
        axial_plant(spool(tmp_path), "spool")


def test_one_of_several_is_asked_for(tmp_path):
    second = SPOOL.replace("spool = {", 'other = { type = "rod" }\nspool = {') + SECOND.replace("slide", "other", 1)
    system = spool(tmp_path, second.replace('rod = "slide"\nmass', 'rod = "other"\nmass'))
    with pytest.raises(ConfigError, match=wording.observability.which_one + ".*slide, other"):
        axial_plant(system)
    assert axial_plant(system, "other").plant == pytest.approx((1.5, 0.0, 0.0), abs=1e-12)


def test_a_spring_that_pushes_away_is_refused(tmp_path):
    """Over the centre: the force falls with the position, and no place is at rest."""
    with pytest.raises(ConfigError, match="slide: " + wording.observability.off_every_place):
        axial_plant(_pushing(spool(tmp_path)))


def _pushing(system):
    """The same circuit with its positions the other way round in the rod's force."""
    from dataclasses import replace

    model = system.model
    rates_of = model.circuit

    def circuit(t, state, command, params):
        position = -state.slide.position
        rates, *rest = rates_of(t, state._replace(slide=state.slide._replace(position=position)), command, params)
        return rates, *rest

    return replace(system, circuit=replace(system.circuit, model=replace(model, circuit=circuit)))
