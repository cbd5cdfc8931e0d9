"""The loss over a relief valve.

All 20 L/min of a pump go over a relief valve that opens at 150 bar and is at 160 bar with its rated flow of
40 L/min; in between its flow grows evenly with the pressure. Which power turns to heat in it?
"""

from vvdp.api.exercise import ask

CIRCUIT = """
[oil]
air_fraction = "0"
[nodes]
tank = { type = "tank" }
line = { type = "volume", volume = "0.1 l", start = "150 bar" }
[components.supply]
type = "flow-source"
a = "tank"
b = "line"
flow = "20 lpm"
[components.relief_valve]
type = "relief-valve"
a = "line"
b = "tank"
cracking_pressure = "150 bar"
override_pressure = "10 bar"
rated_flow = "40 lpm"
[run]
until = "0.5 s"
average_from = "0.4 s"
"""

EXERCISE = ask(
    __name__,
    __doc__,
    circuit=CIRCUIT,
    key="loss_relief_valve_W",
    hint="The power is pressure times flow; find first the pressure at which 20 L/min pass.",
    mistakes=(
        (
            lambda right: right * 150 / 155,
            "That is with the pressure at which the valve opens; with 20 L/min it is higher.",
        ),
        (lambda right: right * 160 / 155, "That is with the pressure at the rated flow of 40 L/min."),
        (lambda right: 600.0 * right, "bar times L/min are not watts: divide by 600 for kilowatts."),
    ),
)
