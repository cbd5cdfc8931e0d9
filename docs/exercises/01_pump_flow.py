"""The flow of a pump.

A pump of 16 cm³/rev turns at 1500 rpm. It has no leakage. Which flow does it give to a line at 100 bar?
"""

from vvdp.api.exercise import ask

CIRCUIT = """
[oil]
air_fraction = "0"
[nodes]
tank = { type = "tank" }
line = { type = "pressure-source", pressure = "100 bar" }
motor = { type = "driven-shaft", speed = "1500 rpm" }
[components.pump]
type = "pump"
inlet = "tank"
outlet = "line"
shaft = "motor"
displacement = "16 cc/rev"
leakage_conductance = "0 m^3/(s*Pa)"
ripple_amplitude = "0"
ripple_count = "9"
friction_torque = "0 N*m"
[run]
until = "0.1 s"
"""

EXERCISE = ask(
    __name__,
    __doc__,
    circuit=CIRCUIT,
    key="flow_mean_pump_m3_s",
    hint="A pump gives its displacement once per revolution.",
)
