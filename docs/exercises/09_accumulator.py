"""An accumulator that is charged fast.

An accumulator holds 1 L of nitrogen at 10 bar gauge. 0.4 L of oil go into it so fast that no heat leaves the
gas (exponent 1.4). Which gauge pressure has it then?
"""

from vvdp.api.exercise import ask

CIRCUIT = """
[oil]
air_fraction = "0"
[nodes]
tank = { type = "tank" }
[nodes.accumulator]
type = "vessel"
oil_volume = "1 cc"
gas_volume = "1 l"
precharge_pressure = "10 bar"
gas_exponent = "1.4"
start = "10 bar"
[components.supply]
type = "flow-source"
a = "tank"
b = "accumulator"
flow = "12 lpm"
[run]
until = "2 s"
"""

EXERCISE = ask(
    __name__,
    __doc__,
    circuit=CIRCUIT,
    key="pressure_max_accumulator_Pa",
    hint="p V^1.4 stays the same, with the absolute pressure.",
    mistakes=(
        (
            lambda right: 11.01325e5 / 0.6 - 1.01325e5,
            "That is Boyle's law, of a gas that keeps its temperature; compressed so fast, it warms.",
        ),
        (
            lambda right: 10e5 / 0.6**1.4,
            "The gas law needs absolute pressures: 11 bar, and the atmosphere taken off again at the end.",
        ),
        (lambda right: 11.01325e5 / 0.4**1.4 - 1.01325e5, "0.4 L is what went in; 0.6 L of the gas are left."),
    ),
)
