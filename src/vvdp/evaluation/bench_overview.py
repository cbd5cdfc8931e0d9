"""The numbers of a test rig of the rotary valve: what each means, and the lines that a user is shown."""

from vvdp.base.display import plain
from vvdp.base.kinds import (
    COUNT,
    EFFICIENCY,
    FLAG,
    FLOW,
    FRACTION,
    FREQUENCY,
    GAUGE_PRESSURE,
    MEAN_POWER,
    NUMBER,
    SPEED,
    Kind,
)
from vvdp.systems.extras import Line
from vvdp.valve.validity import CAVITATION_NUMBER

ANALYTIC = (
    "analytic_pwm_frequency_Hz",
    "analytic_pwm_frequency_full_open_Hz",
    "analytic_loss_full_open_W",
    "analytic_loss_transition_W",
    "analytic_loss_leakage_W",
    "analytic_loss_compressibility_W",
    "analytic_loss_pump_W",
    "analytic_loss_total_W",
    "analytic_load_flow_m3_s",
)
"""Keys of the closed forms, in the order of `RotaryBench.closed_forms`."""

LEAKAGE = ("analytic_loss_leakage_W",)
PUMP = ("loss_pump_leakage_W", "loss_pump_friction_W")
TRANSITION = ("analytic_loss_transition_W", "analytic_loss_compressibility_W")
QUANTITIES: dict[str, tuple[Kind, str]] = {
    "pwm_frequency_Hz": (FREQUENCY, "PWM frequency"),
    "mean_pump_flow_m3_s": (FLOW, "pump flow, mean"),
    "mean_load_flow_m3_s": (FLOW, "flow to the load, mean"),
    "mean_tank_flow_m3_s": (FLOW, "flow to the tank through the valve, mean"),
    "mean_leakage_flow_m3_s": (FLOW, "leakage of the valve, mean"),
    "load_flow_fraction": (EFFICIENCY, "load flow over pump flow"),
    "mean_load_opening": (FRACTION, "open fraction of the load port, mean"),
    "cavitation_port_share": (FRACTION, "port cavitation, share of time"),
    "cavitation_number_lowest": (NUMBER, "cavitation number of the ports, lowest"),
    "input_power_W": (MEAN_POWER, "input power at the pump shaft"),
    "spool_motor_power_W": (MEAN_POWER, "input power of the spool motor"),
    "load_power_W": (MEAN_POWER, "load power"),
    "efficiency": (EFFICIENCY, "efficiency"),
    "motor_rated_power_W": (MEAN_POWER, "rated power of the motor"),
    "motor_overloaded": (FLAG, "motor overloaded"),
    "loss_nozzle_W": (MEAN_POWER, "loss in the nozzles"),
    "loss_centre_section_W": (MEAN_POWER, "loss in the centre section"),
    "loss_outlet_turbine_W": (MEAN_POWER, "loss in the outlet turbine"),
    "loss_spool_friction_W": (MEAN_POWER, "loss by spool friction"),
    "spool_shaft_power_W": (MEAN_POWER, "power from the flow to the spool"),
    "loss_full_open_W": (MEAN_POWER, "loss of the fully open valve"),
    "loss_transition_W": (MEAN_POWER, "loss by transition and compression"),
    "loss_total_W": (MEAN_POWER, "input power minus load power"),
    "steady": (FLAG, "nothing prescribed changes"),
    "analytic_pwm_frequency_Hz": (FREQUENCY, "PWM frequency, analytic"),
    "analytic_pwm_frequency_full_open_Hz": (FREQUENCY, "PWM frequency, analytic, valve fully open"),
    "analytic_loss_full_open_W": (MEAN_POWER, "loss of the fully open valve, analytic"),
    "analytic_loss_transition_W": (MEAN_POWER, "loss by transition, analytic"),
    "analytic_loss_leakage_W": (MEAN_POWER, "loss by leakage of the valve, analytic"),
    "analytic_loss_compressibility_W": (MEAN_POWER, "loss by compression, analytic"),
    "analytic_loss_pump_W": (MEAN_POWER, "loss by leakage and friction of the pump, analytic"),
    "analytic_loss_total_W": (MEAN_POWER, "losses, analytic"),
    "analytic_load_flow_m3_s": (FLOW, "flow to the load, analytic"),
}
"""Lines that a bench adds to a summary."""

OVERVIEW: tuple[Line, ...] = (
    Line("PWM frequency", ("pwm_frequency_Hz",), FREQUENCY, ("analytic_pwm_frequency_Hz",), "Valve"),
    Line("PWM periods averaged", ("averaged_periods",), COUNT, (), "Valve"),
    Line("spool speed, mean", ("speed_mean_spool_rad_s",), SPEED, (), "Valve"),
    Line("spool speed, lowest", ("speed_min_spool_rad_s",), SPEED, (), "Valve"),
    Line("spool speed, highest", ("speed_max_spool_rad_s",), SPEED, (), "Valve"),
    Line("open fraction of the load port, mean", ("mean_load_opening",), FRACTION, (), "Valve"),
    Line("port cavitation, share of time", ("cavitation_port_share",), FRACTION, (), "Valve"),
    Line("cavitation number of the ports, lowest", ("cavitation_number_lowest",), NUMBER, (), "Valve"),
    Line("pump flow, displaced", ("mean_pump_flow_m3_s",), FLOW, (), "Flows, mean"),
    Line("flow to the load", ("mean_load_flow_m3_s",), FLOW, ("analytic_load_flow_m3_s",), "Flows, mean"),
    Line("flow to the tank", ("mean_tank_flow_m3_s",), FLOW, (), "Flows, mean"),
    Line("flow over the relief valve", ("flow_mean_relief_valve_m3_s",), FLOW, (), "Flows, mean"),
    Line("leakage of the valve", ("mean_leakage_flow_m3_s",), FLOW, (), "Flows, mean"),
    Line("load flow over pump flow", ("load_flow_fraction",), EFFICIENCY, (), "Flows, mean"),
    Line("inlet pressure, mean", ("pressure_mean_inlet_Pa",), GAUGE_PRESSURE, (), "Pressures"),
    Line("inlet pressure, lowest", ("pressure_min_inlet_Pa",), GAUGE_PRESSURE, (), "Pressures"),
    Line("inlet pressure, highest", ("pressure_max_inlet_Pa",), GAUGE_PRESSURE, (), "Pressures"),
    Line("load pressure, mean", ("pressure_mean_load_line_Pa",), GAUGE_PRESSURE, (), "Pressures"),
    Line("load pressure, lowest", ("pressure_min_load_line_Pa",), GAUGE_PRESSURE, (), "Pressures"),
    Line("load pressure, highest", ("pressure_max_load_line_Pa",), GAUGE_PRESSURE, (), "Pressures"),
    Line("input power, pump shaft", ("input_power_W",), MEAN_POWER, (), "Power, mean"),
    Line("input power, spool motor", ("spool_motor_power_W",), MEAN_POWER, (), "Power, mean"),
    Line("rated power of the motor", ("motor_rated_power_W",), MEAN_POWER, (), "Power, mean"),
    Line("load power", ("load_power_W",), MEAN_POWER, (), "Power, mean"),
    Line("efficiency", ("efficiency",), EFFICIENCY, (), "Power, mean"),
    Line("loss, fully open valve", ("loss_full_open_W",), MEAN_POWER, ("analytic_loss_full_open_W",), "Losses"),
    Line("loss, transition and compression", ("loss_transition_W",), MEAN_POWER, TRANSITION, "Losses"),
    Line("loss, leakage of the valve", ("loss_valve_leakage_W",), MEAN_POWER, ("analytic_loss_leakage_W",), "Losses"),
    Line("loss, leakage and friction of the pump", PUMP, MEAN_POWER, ("analytic_loss_pump_W",), "Losses"),
    Line("pump filling loss", ("loss_pump_compression_W",), MEAN_POWER, (), "Losses"),
    Line("power stored in oil and spool", ("stored_power_W",), MEAN_POWER, (), "Losses"),
    Line("input power minus load power", ("loss_total_W",), MEAN_POWER, ("analytic_loss_total_W",), "Losses"),
)
"""Simulated numbers beside the analytic ones."""
OVERVIEW_NOTE = (
    "The cavitation number of a port is the pressure that is left above cavitation behind its nozzles over their "
    f"pressure drop; below {plain(CAVITATION_NUMBER)} cavitation is assumed. Each port passes through that "
    "while it is nearly closed, so a low number is usual and no warning: the share shows for how much of the time the "
    "orifice law is in doubt and the edges may erode."
)
