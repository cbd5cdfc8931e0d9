"""The pressure before an orifice.

A flow of 20 L/min passes an orifice of 12 mm² with a discharge coefficient of 0.61 into a tank. The oil has
870 kg/m³. Which pressure is there before the orifice?
"""

from vvdp.api.exercise import ask

CIRCUIT = """
[oil]
density = "870 kg/m^3"
density_temperature = "40 degC"
air_fraction = "0"
[nodes]
tank = { type = "tank" }
line = { type = "volume", volume = "0.1 l", start = "0 bar" }
[components.supply]
type = "flow-source"
a = "tank"
b = "line"
flow = "20 lpm"
[components.orifice]
type = "orifice"
a = "line"
b = "tank"
area = "12 mm^2"
discharge_coefficient = "0.61"
[run]
until = "0.5 s"
average_from = "0.4 s"
"""

EXERCISE = ask(
    __name__,
    __doc__,
    circuit=CIRCUIT,
    key="pressure_mean_line_Pa",
    hint="Q = Cd A sqrt(2 dp / rho): solve it for the pressure.",
    mistakes=(
        (lambda right: 0.61**2 * right, "The discharge coefficient is missing."),
        (
            lambda right: 0.61 * right,
            "The discharge coefficient enters squared: the flow goes with the root of the pressure.",
        ),
        (
            lambda right: 4.0 * right,
            "The factor before the square of the velocity is 1/2: dp = rho/2 (Q / (Cd A))².",
        ),
    ),
)
