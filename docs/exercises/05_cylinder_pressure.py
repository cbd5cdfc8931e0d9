"""The pressure in a cylinder.

The cylinder of exercise 4, with a piston of 2000 mm², pushes 10 kN slowly; the ring is open to the tank.
Which pressure is in the chamber?
"""

from vvdp.api.exercise import ask

CIRCUIT = """
[oil]
air_fraction = "0"
[nodes]
tank = { type = "tank" }
chamber = { type = "volume", volume = "50 cc", start = "50 bar" }
ring = { type = "volume", volume = "50 cc", start = "0 bar" }
rod = { type = "rod", position = "0 mm" }
[components.supply]
type = "flow-source"
a = "tank"
b = "chamber"
flow = "12 lpm"
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
force = "-10 kN"
[run]
until = "0.5 s"
average_from = "0.3 s"
"""

EXERCISE = ask(
    __name__,
    __doc__,
    circuit=CIRCUIT,
    key="pressure_mean_chamber_Pa",
    hint="Pressure is force over area.",
    mistakes=(
        (lambda right: right * 2000 / 1200, "The force acts on the whole piston: the ring is open to the tank."),
        (lambda right: 0.1 * right, "N/mm² are MPa: 1 MPa is 10 bar."),
    ),
)
