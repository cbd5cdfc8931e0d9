"""The speed of a motor.

30 L/min drive a hydraulic motor of 25 cm³/rev without leakage. How fast does its shaft turn?
"""

from vvdp.api.exercise import ask

CIRCUIT = """
[oil]
air_fraction = "0"
[nodes]
tank = { type = "tank" }
line = { type = "volume", volume = "20 cc", start = "1 bar" }
shaft = { type = "shaft" }
[components.supply]
type = "flow-source"
a = "tank"
b = "line"
flow = { ramp = ["0 lpm", "30 lpm"], from = "0 s", to = "1 s" }
[components.motor]
type = "motor"
a = "line"
b = "tank"
shaft = "shaft"
displacement = "25 cc/rev"
leakage_conductance = "0 m^3/(s*Pa)"
shaft_damping = "0.1 N*m*s"
coulomb_torque = "0 N*m"
coulomb_speed = "1800 rpm"
inertia = "0.01 kg*m^2"
[run]
until = "3 s"
average_from = "2.5 s"
"""

EXERCISE = ask(
    __name__,
    __doc__,
    circuit=CIRCUIT,
    key="speed_mean_shaft_rad_s",
    hint="In one revolution the motor takes its displacement.",
    mistakes=(),
)
