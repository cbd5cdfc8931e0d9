"""The programs by the names that a system file uses."""

from collections.abc import Mapping

from vvdp.network.program import ProgramType
from vvdp.programs.arithmetic import PRODUCT, SUM, TABLE
from vvdp.programs.axial_sensor import AXIAL_SENSOR
from vvdp.programs.chamber_laws import BACKSTEPPING, PASSIVITY, PRINTED_PASSIVITY
from vvdp.programs.chamber_observer import CHAMBER_OBSERVER
from vvdp.programs.coded_loop import CODED_POSITION_LOOP
from vvdp.programs.controllers import PI, PID
from vvdp.programs.displacement_law import DISPLACEMENT_CONTROL
from vvdp.programs.encoders import ENCODER, EVENT_FILTER, THRESHOLD
from vvdp.programs.estimators import FLOW_MAP, LOAD_OBSERVER, PERIOD_AVERAGE
from vvdp.programs.filters import DERIVATIVE, LIMIT, LOW_PASS, RATE_LIMIT, REFERENCE
from vvdp.programs.generic import GenericProgram
from vvdp.programs.gerotor_control import FEEDFORWARD_PI, GEROTOR_OBSERVER
from vvdp.programs.gerotor_filters import GENERATOR_OBSERVER, LUMPED_OBSERVER
from vvdp.programs.machine.table import MACHINE_CONTROL
from vvdp.programs.metering_edges import EDGE_POSITION_LOOP
from vvdp.programs.piston_law import PISTON_LAW
from vvdp.programs.position_loops import ONE_WAY_POSITION_LOOP, OVERCENTRE_POSITION_LOOP, THROTTLE_POSITION_LOOP
from vvdp.programs.pulses import CYCLE, PWM
from vvdp.programs.stages import COMPARATOR, SEQUENCE, SUPERVISION
from vvdp.programs.tally import TALLY
from vvdp.programs.unloading import UNLOADING

PROGRAMS: Mapping[str, ProgramType | GenericProgram] = {
    "axial-sensor": AXIAL_SENSOR,
    "backstepping": BACKSTEPPING,
    "chamber-observer": CHAMBER_OBSERVER,
    "coded-position-loop": CODED_POSITION_LOOP,
    "comparator": COMPARATOR,
    "cycle": CYCLE,
    "derivative": DERIVATIVE,
    "displacement-control": DISPLACEMENT_CONTROL,
    "edge-position-loop": EDGE_POSITION_LOOP,
    "encoder": ENCODER,
    "event-filter": EVENT_FILTER,
    "feedforward-pi": FEEDFORWARD_PI,
    "flow-map": FLOW_MAP,
    "generator-observer": GENERATOR_OBSERVER,
    "gerotor-observer": GEROTOR_OBSERVER,
    "limit": LIMIT,
    "load-observer": LOAD_OBSERVER,
    "low-pass": LOW_PASS,
    "lumped-observer": LUMPED_OBSERVER,
    "machine-control": MACHINE_CONTROL,
    "one-way-position-loop": ONE_WAY_POSITION_LOOP,
    "overcentre-position-loop": OVERCENTRE_POSITION_LOOP,
    "passivity": PASSIVITY,
    "period-average": PERIOD_AVERAGE,
    "pi": PI,
    "pid": PID,
    "piston-law": PISTON_LAW,
    "printed-passivity": PRINTED_PASSIVITY,
    "product": PRODUCT,
    "pwm": PWM,
    "rate-limit": RATE_LIMIT,
    "reference": REFERENCE,
    "sequence": SEQUENCE,
    "sum": SUM,
    "supervision": SUPERVISION,
    "table": TABLE,
    "tally": TALLY,
    "threshold": THRESHOLD,
    "throttle-position-loop": THROTTLE_POSITION_LOOP,
    "unloading": UNLOADING,
}
"""Programs that a system file can name, by their type."""
