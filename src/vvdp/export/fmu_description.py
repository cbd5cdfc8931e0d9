"""The model description of an FMU, for FMI 2 and FMI 3, and what tells a tool how to compile its sources."""

from collections.abc import Iterator, Sequence
from importlib.metadata import version
from xml.sax.saxutils import quoteattr

from vvdp.base.kinds import Kind
from vvdp.export.fmu_model import FIXED, INPUT, FmuModel, Settable
from vvdp.export.fmu_units import display_name, unit_lines, unit_name
from vvdp.generator.c_text import identifier

HEAD = '<?xml version="1.0" encoding="UTF-8"?>\n'


def fmu_name(model: FmuModel) -> str:
    """The model identifier: the name of the system as C has it."""
    return identifier(model.system.name.replace("-", "_"))


def description(model: FmuModel, fmi: int, token: str, sources: Sequence[str]) -> str:
    """The text of `modelDescription.xml`."""
    system = model.system
    name, stepping = fmu_name(model), system.stepping
    states = "FMUState" if fmi == 3 else "FMUstate"
    head = {"fmiVersion": f"{fmi}.0", "modelName": system.name}
    head |= {"instantiationToken" if fmi == 3 else "guid": token, "generationTool": f"vvdp {version('vvdp')}"}
    head["description"] = f"{system.name}: circuit, programs and simulation loop of vvdp"
    able = f'canHandleVariableCommunicationStepSize="true" canGetAndSet{states}="true" canSerialize{states}="true"'
    given = {"startTime": stepping.begin, "stopTime": stepping.until, "tolerance": stepping.relative_tolerance}
    given["stepSize"] = stepping.sample_period
    kinds = [each.kind for each in model.variables]
    lines = [
        f"<fmiModelDescription {_attributes(head)}>",
        f'  <CoSimulation modelIdentifier="{name}" {able}{"/>" if fmi == 3 else ">"}',
        *(["    <SourceFiles>", *(f'      <File name="{each}"/>' for each in sources if each.endswith(".c"))]
          + ["    </SourceFiles>", "  </CoSimulation>"] if fmi == 2 else []),
        "  <UnitDefinitions>",
        *unit_lines(kinds),
        "  </UnitDefinitions>",
        '  <LogCategories>\n    <Category name="logStatusError"/>\n  </LogCategories>',
        f"  <DefaultExperiment {_attributes({key: repr(value) for key, value in given.items()})}/>",
        "  <ModelVariables>",
        *variable_lines(model, fmi),
        "  </ModelVariables>",
        "  <ModelStructure>",
        *_structure(model, fmi),
        "  </ModelStructure>",
        "</fmiModelDescription>",
    ]  # fmt: skip
    return HEAD + "\n".join(lines) + "\n"


def _attributes(values: dict[str, str]) -> str:
    return " ".join(f"{key}={quoteattr(value)}" for key, value in values.items())


def variable_lines(model: FmuModel, fmi: int) -> Iterator[str]:
    """The variables in the order of their references."""
    if fmi == 3:
        time = {"name": "time", "valueReference": "0", "causality": "independent", "variability": "continuous"}
        yield f'    <Float64 {_attributes(time)} description="Time [s]"/>'
    for number, each in enumerate(model.settables, 1):
        own = {"name": each.name, "valueReference": str(number), "description": each.about, **_role(each)}
        ends = {"min": repr(each.low), "max": repr(each.high)}
        yield _variable(fmi, own, {**_unit(each.kind), **ends, "start": repr(each.start)})
    for number, shown in enumerate(model.outputs, 1 + len(model.settables)):
        variability = "discrete" if shown.is_discrete else "continuous"
        own = {"name": shown.name, "valueReference": str(number), "causality": "output", "variability": variability}
        kind = shown.kind
        nominal = {} if kind is None or not kind.scale > 0.0 else {"nominal": repr(kind.scale)}
        ends = {} if kind is None else {"min": repr(kind.low), "max": repr(kind.high)}
        yield _variable(fmi, {**own, "initial": "calculated"}, {**_unit(kind), **ends, **nominal})


def _role(settable: Settable) -> dict[str, str]:
    if settable.role == INPUT:
        return {"causality": "input", "variability": "continuous"}
    variability = "fixed" if settable.role == FIXED else "tunable"
    return {"causality": "parameter", "variability": variability, "initial": "exact"}


def _unit(kind: Kind | None) -> dict[str, str]:
    found = {"quantity": "" if kind is None else kind.name, "unit": unit_name(kind), "displayUnit": display_name(kind)}
    return {key: value for key, value in found.items() if value}


def _variable(fmi: int, own: dict[str, str], number: dict[str, str]) -> str:
    if fmi == 3:
        return f"    <Float64 {_attributes({**own, **number})}/>"
    return f"    <ScalarVariable {_attributes(own)}><Real {_attributes(number)}/></ScalarVariable>"


def _structure(model: FmuModel, fmi: int) -> Iterator[str]:
    first = 1 + len(model.settables)
    numbers = range(first, first + len(model.outputs))
    if fmi == 3:
        yield from (f'    <Output valueReference="{number}"/>' for number in numbers)
        yield from (f'    <InitialUnknown valueReference="{number}"/>' for number in numbers)
        return
    for tag in ("Outputs", "InitialUnknowns"):
        yield f"    <{tag}>"
        yield from (f'      <Unknown index="{number}"/>' for number in numbers)
        yield f"    </{tag}>"


def build_description(model: FmuModel, sources: Sequence[str], flags: Sequence[str]) -> str:
    """The text of `buildDescription.xml` of FMI 3: sources, and the flags that are part of them."""
    files = "".join(f'      <SourceFile name="{each}"/>\n' for each in sources if each.endswith(".c"))
    return (
        f'{HEAD}<fmiBuildDescription fmiVersion="3.0">\n'
        f'  <BuildConfiguration modelIdentifier="{fmu_name(model)}">\n'
        f'    <SourceFileSet language="C99" compilerOptions={quoteattr(" ".join(flags))}>\n{files}'
        '    </SourceFileSet>\n    <Library name="m" external="true"/>\n'
        "  </BuildConfiguration>\n</fmiBuildDescription>\n"
    )
