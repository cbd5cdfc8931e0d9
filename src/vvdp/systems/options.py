"""Changes that options of a command make in a system file before it is read."""

from collections.abc import Mapping, Sequence
from typing import Any

from vvdp.base.errors import ConfigError, Fault, ParameterError
from vvdp.base.kinds import TIME
from vvdp.base.rules import POSITIVE
from vvdp.base.tables import SET_BY_OPTION, Table
from vvdp.base.units import parse


def option_keys(settings: Sequence[str]) -> set[str]:
    """The keys and values that settings of the form table.key=value set."""
    return {setting.partition("=")[0].strip() for setting in settings}


def without_other_position(table: Table, settings: Sequence[str]) -> Table:
    """`table` without the duty ratio where a setting gives the axial position instead, and the other way round."""
    operation = table.content.get("operation")
    if not isinstance(operation, Mapping):
        return table
    given, kept = option_keys(settings), dict(operation)
    for one, other in (("axial_position", "duty_ratio"), ("duty_ratio", "axial_position")):
        if f"operation.{one}" in given and f"operation.{other}" not in given:
            kept.pop(other, None)
    return Table(table.place, {**table.content, "operation": kept}, table.lines)


def lasting(table: Table, until: str, settings: Sequence[str] = ()) -> Table:
    """`table`, in which `settings` stand already, with a run of `until`.

    Means are then taken from the same share of the run as the file has it, unless a setting says from when.
    """
    try:
        seconds = parse(until, TIME)
    except ParameterError as problem:
        raise ConfigError([Fault("--until", 0, "", str(problem))]) from None
    if not seconds > 0.0:
        raise ConfigError([Fault("--until", 0, "", f"{until!r} {POSITIVE}")])
    run = table.content.get("run", {})
    if not isinstance(run, Mapping):
        return table
    try:
        share = duration_of(run.get("average_from")) / duration_of(run.get("until"))
    except (ParameterError, ZeroDivisionError):
        share = 0.5
    share = share if 0.0 <= share < 1.0 else 0.5  # of a run.until that was set as well
    given = {} if "run.average_from" in option_keys(settings) else {"average_from": f"{share * seconds!r} s"}
    lines = {**table.lines, "run.until": SET_BY_OPTION}
    return Table(table.place, {**table.content, "run": {**run, **given, "until": f"{seconds!r} s"}}, lines)


def duration_of(entry: Any) -> float:
    """The time of an entry of [run], with its origin or without [s]. Raises ParameterError."""
    return parse(entry.get("value") if isinstance(entry, Mapping) else entry, TIME)
