"""The circuit diagram of a bench, with the values of the system that was run."""

from collections.abc import Iterator

from vvdp.base.signal import Signal
from vvdp.report import symbols as draw
from vvdp.report.reading import BAR, LPM, Reading
from vvdp.report.wording import brief, fixed, number, percent

WIDTH, HEIGHT = 976, 520
MAIN, RETURN, TOP = 318.0, 492.0, 112.0
"""Heights of the pump's line, of the tanks, and of the load's line."""
PUMP, RELIEF, VALVE, LOAD = 150.0, 330.0, 520.0, 868.0


def circuit_diagram(reading: Reading) -> str:
    """The diagram as one SVG element."""
    parts = "\n".join(_parts(reading))
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {HEIGHT}" role="img" '
        f'font-family="Helvetica Neue, Arial, Liberation Sans, DejaVu Sans, sans-serif" font-size="13.5">\n'
        f"<title>Circuit diagram</title>\n"
        f'<g fill="none" stroke="{draw.INK}" stroke-width="1.7" stroke-linecap="round" stroke-linejoin="round">\n'
        f"{parts}\n</g>\n</svg>\n"
    )


def _value(reading: Reading, table: str, key: str, digits: int = 4) -> str:
    row = reading.row(table, key)
    return brief(row, digits) if row else "–"


def _parts(reading: Reading) -> Iterator[str]:
    yield from _supply(reading)
    yield from _valve(reading)
    yield from _load_line(reading)


def _supply(reading: Reading) -> Iterator[str]:
    port, x, y = VALVE + 18.0, PUMP, 400.0
    relief = reading.supply.relief_valve
    flow = reading.supply.pump.displacement * reading.start(reading.operation.pump_speed) / LPM
    yield draw.electric_motor(x - 92, y) + draw.shaft(x - 66, x - 30, y) + draw.pump(x, y)
    yield draw.pipe((x, y + 30), (x, RETURN)) + draw.tank(x, RETURN)
    yield draw.pipe((x, y - 30), (x, MAIN), (port, MAIN), (port, 262))
    yield draw.label(x - 92, y + 48, ["Motor", _value(reading, "motor", "rated_power")], "middle")
    displacement, speed = _value(reading, "pump", "displacement"), _value(reading, "operation", "pump_speed")
    yield draw.label(x + 42, y - 12, ["Pump", displacement, speed, f"{fixed(flow, 1)} lpm"])
    temperature, pressure = (_value(reading, "operation", key) for key in ("oil_temperature", "tank_pressure"))
    yield draw.label(x + 34, RETURN + 6, ["Tank", f"{pressure}, {temperature}"])
    yield draw.junction(RELIEF, MAIN) + draw.pipe((RELIEF, MAIN), (RELIEF, 376)) + draw.relief_valve(RELIEF, 400)
    yield draw.pipe((RELIEF, 424), (RELIEF, RETURN)) + draw.tank(RELIEF, RETURN)
    manner = (
        f"+ {number(relief.override_pressure / BAR, 3)} bar at rated flow"
        if relief.override_pressure
        else "holds its setting"
    )
    yield draw.label(RELIEF + 62, 390, ["Relief valve", _value(reading, "relief_valve", "cracking_pressure"), manner])
    rail = RELIEF - 92
    yield draw.junction(rail, MAIN) + draw.pipe((rail, MAIN), (rail, MAIN - 22)) + draw.gauge(rail, MAIN - 22)
    low, high = (reading.number(f"inlet_pressure_{end}_Pa") / BAR for end in ("min", "max"))
    inlet = [
        f"mean {fixed(reading.number('mean_inlet_pressure_Pa') / BAR, 1)} bar",
        f"{fixed(low, 1)} to {fixed(high, 1)} bar",
    ]
    yield draw.label(rail - 30, MAIN - 62, ["Inlet", *inlet], "end")
    yield draw.label(RELIEF + 14, MAIN - 12, [f"Inlet volume {_value(reading, 'inlet', 'volume')}"])


def _valve(reading: Reading) -> Iterator[str]:
    x, y, valve = VALVE, 230.0, reading.supply.valve
    frequency, drive = reading.number("pwm_frequency_Hz"), reading.supply.spool_drive
    yield draw.rotary_valve(x, y) + draw.rotary_drive(x - 64, y) + draw.set_position(x + 64, y)
    yield draw.pipe((x + 46, 262), (x + 46, RETURN)) + draw.tank(x + 46, RETURN)
    yield draw.label(
        x + 2,
        TOP + 24,
        [
            "Rotary valve",
            f"{number(valve.sections, 3).rstrip('0').rstrip('.')} sections",
            f"nozzles {_value(reading, 'valve', 'nozzle_area')}",
        ],
        "end",
    )
    turned = "driven" if drive.coupling > 0.0 else "self-spinning"
    yield draw.label(x - 120, y - 6, ["Spool", f"{turned}, PWM {fixed(frequency, 1)} Hz"], "end")
    duty, axial = reading.duty_ratio, reading.operation.axial_position
    place = f"{fixed(1e3 * reading.start(axial), 2)} mm of {fixed(1e3 * valve.helix_length, 2)} mm"
    low, high = duty.extremes
    ratio = fixed(low, 3) if duty.is_constant else f"{fixed(low, 3)} to {fixed(high, 3)}"
    yield draw.label(
        x + 120, y - 15, [f"Duty ratio {ratio}", "axial position", place + ("" if duty.is_constant else " at start")]
    )


def _load_line(reading: Reading) -> Iterator[str]:
    begin, check = VALVE + 18.0, reading.supply.check_valve
    at = begin
    yield draw.pipe((begin, 198), (begin, TOP))
    if check.reverse_opening < 1.0:
        x = begin + 54
        yield draw.pipe((at, TOP), (x - 18, TOP)) + draw.check_valve(x, TOP)
        crack = f"{number(check.cracking_pressure / BAR, 3)} bar"
        yield draw.label(x, TOP - 42, ["Check valve", crack], "middle")
        at = x + 18
    if reading.has_load_line:
        line = reading.system.case.params.load_line
        x0, x1 = begin + 110.0, begin + 190.0
        yield draw.pipe((at, TOP), (x0, TOP)) + draw.hose(x0, x1, TOP)
        yield draw.label(x0 + 40, TOP + 52, ["Load line", _value(reading, "load_line", "oil_volume")], "middle")
        at = x1
        if line.gas_volume > 0.0:
            x = begin + 226.0
            yield draw.junction(x, TOP) + draw.pipe((x, TOP), (x, TOP - 14)) + draw.accumulator(x, TOP - 14)
            gas, charge = (_value(reading, "load_line", key) for key in ("gas_volume", "precharge_pressure"))
            yield draw.label(x - 26, TOP - 88, ["Accumulator", f"{gas}, precharge {charge}"], "end")
    yield draw.pipe((at, TOP), (LOAD, TOP), (LOAD, 274))
    yield (
        draw.junction(LOAD - 44, TOP)
        + draw.pipe((LOAD - 44, TOP), (LOAD - 44, TOP - 14))
        + draw.gauge(LOAD - 44, TOP - 14)
    )
    mean = fixed(reading.number("mean_load_pressure_Pa") / BAR, 1)
    ends = [reading.number(f"load_pressure_{end}_Pa") / BAR for end in ("min", "max")]
    swing = [f"{fixed(ends[0], 1)} to {fixed(ends[1], 1)} bar"] if reading.has_load_line else []
    yield draw.label(LOAD - 14, TOP - 62, ["Load", f"mean {mean} bar", *swing])
    fraction = percent(reading.number("load_flow_fraction"))
    flow = f"{fixed(reading.number('mean_load_flow_m3_s') / LPM, 2)} lpm"
    share = f"{fraction} of pump flow"
    if reading.has_load_line:
        area = reading.system.case.params.load.area
        varies = isinstance(area, Signal) and not area.is_constant
        yield draw.throttle(LOAD, 300, adjustable=varies)
        yield draw.pipe((LOAD, 326), (LOAD, RETURN)) + draw.tank(LOAD, RETURN)
        lines = ["Load orifice", _value(reading, "load", "area"), flow, share]
        yield draw.label(LOAD - 34, 280, lines, "end")
    else:
        yield draw.pressure_source(LOAD, 274)
        lines = ["Pressure source", _value(reading, "load", "pressure"), flow, share]
        yield draw.label(LOAD - 40, 280, lines, "end")
