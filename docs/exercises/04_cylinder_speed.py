"""The speed of a cylinder.

12 L/min flow into the chamber of a cylinder with a piston of 2000 mm² and a ring of 1200 mm². It lifts 5 kN.
How fast does its rod go out?
"""

from vvdp.api.exercise import ask

CIRCUIT = """
[oil]
air_fraction = "0"
[nodes]
tank = { type = "tank" }
chamber = { type = "volume", volume = "50 cc", start = "25 bar" }
ring = { type = "volume", volume = "50 cc", start = "0 bar" }
rod = { type = "rod", position = "0 mm" }
[components.supply]
type = "flow-source"
a = "tank"
b = "chamber"
flow = { ramp = ["0 lpm", "12 lpm"], from = "0 s", to = "0.2 s" }
[components.drain]
type = "orifice"
a = "ring"
b = "tank"
area = "1000 mm^2"
[components.cylinder]
type = "cylinder"
a = "chamber"
b = "ring"
rod = "rod"
area_a = "2000 mm^2"
area_b = "1200 mm^2"
stroke = "500 mm"
moving_mass = "5 kg"
leakage_conductance = "0 m^3/(s*Pa)"
[components.load]
type = "load-force"
rod = "rod"
force = "-5 kN"
[run]
until = "0.5 s"
average_from = "0.3 s"
"""

EXERCISE = ask(
    __name__,
    __doc__,
    circuit=CIRCUIT,
    key="velocity_mean_rod_m_s",
    hint="The rod goes out so fast that the chamber takes the flow.",
    mistakes=(
        (
            lambda right: right * 2000 / 1200,
            "The ring area is the one on the side of the rod; the flow goes into the chamber behind the piston.",
        ),
        (lambda right: right * 2000 / 800, "That is flow over the area of the rod alone."),
    ),
)
