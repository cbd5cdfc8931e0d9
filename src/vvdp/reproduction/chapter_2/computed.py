"""Flows that were computed beforehand, kept as tables with the command that repeats them."""

from vvdp.base import kinds
from vvdp.base.kinds import Kind
from vvdp.cfd.kept import KeptStudy, kept_studies, kept_study
from vvdp.results.result import Column, Table

KINDS = {
    "m3_s": kinds.FLOW,
    "N_m": kinds.TORQUE,
    "rad_s": kinds.SPEED,
    "m3": kinds.VOLUME,
    "m2": kinds.AREA,
    "Pa": kinds.SIGNED_PRESSURE,
    "N": kinds.FORCE,
    "m": kinds.LENGTH,
    "rad": kinds.ANGLE,
}
"""Kinds of the columns of a kept study, by the unit with which their names end."""


def kept_or_none(name: str) -> KeptStudy | None:
    """A kept study; None where it is not there."""
    return kept_study(name) if name in kept_studies() else None


def kind_of(key: str, is_text: bool) -> Kind | None:
    """The kind of a column."""
    if is_text:
        return None
    return next((kind for unit, kind in KINDS.items() if key.endswith(f"_{unit}")), kinds.NUMBER)


def kept_table(study: KeptStudy) -> Table:
    """A kept study as a table of a result, with its command."""
    columns = {
        key: Column(values, kind_of(key, values.dtype.kind == "U"), key.replace("_", " "))
        for key, values in study.columns.items()
    }
    return Table(title=f"Computed beforehand: {study.command}", columns=columns, note=study.provenance)
