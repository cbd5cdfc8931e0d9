"""The functions of a model as entries of one unit."""

from vvdp.generator.unit import Options, Unit
from vvdp.simulation.dialect import model_options
from vvdp.simulation.link import ModelAssemblies
from vvdp.simulation.model import Case, Model


def unit_of(model: Model, case: Case, chosen: Options | None = None) -> Unit:
    """Every function of a model; sensors and steps of programs bear the number of the program."""
    unit, assemblies = Unit(chosen or model_options()), ModelAssemblies(model, case)
    for part in assemblies.circuit.parts:
        unit.add(part.function(), part.kinds, part.name)
    for number, pair in enumerate(assemblies.programs):
        for each in pair:
            (part,) = each.parts
            unit.add(part.function(), part.kinds, f"{part.name}_{number}")
    return unit
