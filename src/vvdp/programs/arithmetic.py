"""Programs that combine what they read: weighted sum, product, table of one or two inputs."""

from collections.abc import Sequence
from typing import Annotated, NamedTuple

from vvdp.base.kinds import Kind
from vvdp.base.params import Params
from vvdp.base.rules import refuse_rows, require_rising
from vvdp.base.select import clip
from vvdp.network.program import ProgramType
from vvdp.programs.controllers import Value
from vvdp.programs.generic import GenericProgram, Written
from vvdp.programs.quantities import (
    DIFFERENCES,
    INPUT,
    OUTPUT,
    SECOND,
    Input,
    Plain,
    Second,
    product,
    written_number,
    written_quantity,
)


class Summands(NamedTuple):
    """Summands: two to four values of one quantity."""

    first: Input
    second: Input
    third: Input = 0.0
    fourth: Input = 0.0


class Weights(Params):
    """Weights of the summands."""

    first_weight: Plain = 1.0
    second_weight: Plain = 1.0
    third_weight: Plain = 1.0
    fourth_weight: Plain = 1.0


def sum_step(t: float, memory: NamedTuple, reading: Summands, settings: Weights) -> tuple[NamedTuple, Value]:
    """Weighted sum of two to four values; of pressures as absolute values."""
    two = settings.first_weight * reading.first + settings.second_weight * reading.second
    return memory, Value(two + settings.third_weight * reading.third + settings.fourth_weight * reading.fourth)


def _sum_quantity(read: Sequence[Kind], values: Written) -> Kind:
    """Levels with weights that add up to 1 are a level again, such as a mean; else a difference."""
    given = [name for name in Summands._fields if name in values]
    whole = sum(written_number(values.get(f"{name}_weight", 1.0)) for name in given)
    return read[0] if abs(whole - 1.0) < 1e-9 else DIFFERENCES.get(read[0], read[0])


class Factors(NamedTuple):
    """Factors of the product."""

    first: Input
    second: Second


def product_step(t: float, memory: NamedTuple, reading: Factors, settings: NamedTuple) -> tuple[NamedTuple, Value]:
    """Product of two values; of pressures as absolute values."""
    return memory, Value(reading.first * reading.second)


def _product_quantity(read: Sequence[Kind], values: Written) -> Kind:
    return product(read[0], read[1])


class Looked(NamedTuple):
    """Place in the table."""

    reads: Input
    second: Second = 0.0


class Grid(Params):
    """Values at each of the `places` of the first input, row by row for each of the second."""

    places: Annotated[tuple[float, ...], INPUT]
    second_places: Annotated[tuple[float, ...], SECOND] = (0.0,)
    values: Annotated[tuple[float, ...], OUTPUT]

    def check(self) -> None:
        require_rising(self, "places")
        require_rising(self, "second_places")
        rows, columns = len(self.second_places), len(self.places)
        if not rows or not columns or len(self.values) != rows * columns:
            expected = f"{columns} places" + (f" x {rows} second_places" if rows > 1 else "")
            refuse_rows(self, "values", f"{len(self.values)} given; expected one for each of the {expected}")


def table_step(t: float, memory: NamedTuple, reading: Looked, settings: Grid) -> tuple[NamedTuple, Value]:
    """Table of one or two inputs; straight lines between its values, which are held beyond the ends."""
    before = row_value(reading.reads, 0, settings)
    value = before
    for row in range(1, len(settings.second_places)):
        near, far = settings.second_places[row - 1], settings.second_places[row]
        here = row_value(reading.reads, row, settings)
        value = value + (here - before) * clip((reading.second - near) / (far - near), 0.0, 1.0)
        before = here
    return memory, Value(value)


def row_value(place: float, row: int, settings: Grid) -> float:
    """The value at a place of the first input in one row of the table."""
    places, begin = settings.places, row * len(settings.places)
    value = settings.values[begin]
    for i in range(len(places) - 1):
        share = clip((place - places[i]) / (places[i + 1] - places[i]), 0.0, 1.0)
        value = value + (settings.values[begin + i + 1] - settings.values[begin + i]) * share
    return value


def _table_quantity(read: Sequence[Kind], values: Written) -> Kind:
    return written_quantity(values.get("values"))


SUM = GenericProgram(ProgramType(sum_step, Summands, Value(0.0), Weights), _sum_quantity)
PRODUCT = GenericProgram(ProgramType(product_step, Factors, Value(0.0)), _product_quantity)
TABLE = GenericProgram(ProgramType(table_step, Looked, Value(0.0), Grid), _table_quantity)
