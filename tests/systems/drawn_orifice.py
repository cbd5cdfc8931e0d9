"""An orifice to the tank, as the table of a drawn circuit."""

ORIFICE = """[components.load]
type = "orifice"
a = "line"
b = "tank"
area = "3 mm^2"
discharge_coefficient = "0.6"
transition_pressure = "0.05 bar"
"""
