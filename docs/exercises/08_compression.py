"""How oil yields.

1 L of oil is locked in at 0 bar, and 10 cm³ are pressed into it. Its bulk modulus is 1.4 GPa, and it has no
air. To which pressure does it rise?
"""

from vvdp.api.exercise import ask

CIRCUIT = """
[oil]
liquid_bulk_modulus = "1.4 GPa"
air_fraction = "0"
[nodes]
tank = { type = "tank" }
line = { type = "volume", volume = "1 l", start = "0 bar" }
[components.supply]
type = "flow-source"
a = "tank"
b = "line"
flow = "6 lpm"
[run]
until = "0.1 s"
"""

EXERCISE = ask(
    __name__,
    __doc__,
    circuit=CIRCUIT,
    key="pressure_max_line_Pa",
    hint="The share by which the oil is compressed, times the bulk modulus.",
    mistakes=(
        (lambda right: 1e-2 * right, "GPa are 10000 bar."),
        (lambda right: 100.0 * right, "The compressed volume belongs over the whole volume of 1 L."),
    ),
)
