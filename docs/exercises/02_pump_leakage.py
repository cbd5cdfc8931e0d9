"""The leakage of a pump.

The pump of exercise 1, 16 cm³/rev at 1500 rpm, has a leakage of 5e-12 m³/(s Pa), from its outlet to its
inlet. Which flow is left at 200 bar?
"""

from vvdp.api.exercise import ask

CIRCUIT = """
[oil]
air_fraction = "0"
[nodes]
tank = { type = "tank" }
line = { type = "pressure-source", pressure = "200 bar" }
motor = { type = "driven-shaft", speed = "1500 rpm" }
[components.pump]
type = "pump"
inlet = "tank"
outlet = "line"
shaft = "motor"
displacement = "16 cc/rev"
leakage_conductance = "5e-12 m^3/(s*Pa)"
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
    hint="Take the leakage, conductance times pressure, off the ideal flow.",
    mistakes=(
        (lambda right: right + 1e-4, "That is the ideal flow: the leakage, conductance times pressure, is missing."),
        (lambda right: right + 2e-4, "The leakage is added: it flows back, and is taken off."),
        (lambda right: 1e-4, "That is the leakage itself; asked is what is left."),
    ),
)
