"""Sections 2.2 and 2.3: the flow's equations, the oil, the pump and its motor."""

import numpy as np

from vvdp.base.kinds import DENSITY as DENSITY_KIND
from vvdp.base.kinds import DYNAMIC_VISCOSITY, FLOW as FLOW_KIND
from vvdp.base.kinds import KINEMATIC_VISCOSITY, NUMBER, PRESSURE_DIFFERENCE
from vvdp.base.units import dimension_of
