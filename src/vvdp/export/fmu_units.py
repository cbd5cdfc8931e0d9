"""Units as FMI describes them: powers of base units, and the units in which tools show a value."""

import re
from collections.abc import Iterable, Iterator
from xml.sax.saxutils import quoteattr

from vvdp.base.display import display_unit
from vvdp.base.kinds import PRESSURE_LEVEL, Kind
from vvdp.base.known_units import known_unit

BASE = ("kg", "m", "s", "K")


def unit_name(kind: Kind | None) -> str:
    """The unit of a variable; empty for a number without one."""
    return "" if kind is None or kind.unit in ("1", "SI") else kind.unit


def display_name(kind: Kind | None) -> str:
    """The unit in which a tool may show a variable; empty if it is the unit itself. A level of pressure is gauge."""
    if kind is None or not unit_name(kind):
        return ""
    if kind.name == PRESSURE_LEVEL.name:
        return "bar (gauge)"
    shown = display_unit(kind)
    return "" if (shown.scale, shown.datum) == (1.0, 0.0) else shown.symbol


def unit_lines(kinds: Iterable[Kind | None]) -> Iterator[str]:
    """The `<Unit>` elements of these kinds."""
    shown: dict[str, dict[str, Kind]] = {}
    for kind in kinds:
        if kind is not None and (name := unit_name(kind)):
            displays = shown.setdefault(name, {})
            if display := display_name(kind):
                displays[display] = kind
    for name, displays in sorted(shown.items()):
        yield f"    <Unit name={quoteattr(name)}>"
        if powers := _powers(name):
            yield f"      <BaseUnit {powers}/>"
        for display, kind in sorted(displays.items()):
            unit = display_unit(kind)
            factor, offset = 1.0 / unit.scale, 0.0 - unit.datum / unit.scale
            yield f'      <DisplayUnit name={quoteattr(display)} factor="{factor!r}" offset="{offset!r}"/>'
        yield "    </Unit>"


def _powers(unit: str) -> str:
    """Whole powers of the base units; empty if some power is a fraction."""
    found = known_unit(unit)
    if found is None or found.size != 1.0 or any(power.denominator != 1 for power in found.powers):
        return ""
    powers = [(base, int(power)) for base, power in zip(BASE, found.powers, strict=True) if power]
    if radians := re.search(r"(/?)[^/]*\brad(?:\^(\d))?", unit):
        sign = -1 if "/" in unit[: radians.end()] and not unit.startswith("rad") else 1
        powers.append(("rad", sign * int(radians[2] or 1)))
    return " ".join(f'{base}="{power}"' for base, power in powers)
