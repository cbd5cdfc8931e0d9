"""The model description of an FMU, for FMI 2 and FMI 3, and what shows a tool how to compile its sources."""

from collections.abc import Iterator, Sequence
from importlib.metadata import version
from xml.sax.saxutils import quoteattr

from vvdp.base.kinds import Kind
from vvdp.export.fmu_model import FIXED, INPUT, FmuModel, Settable, has_clock
from vvdp.export.fmu_units import display_name, unit_lines, unit_name
from vvdp.generator.c_text import identifier
from vvdp.simulation.symbols import Op

ME, CS = "ModelExchange", "CoSimulation"
"""The kinds of FMU by their names in a description."""
HEAD = '<?xml version="1.0" encoding="UTF-8"?>\n'


def fmu_name(model: FmuModel) -> str:
    """The model identifier: the name of the system as C has it."""
    return identifier(model.system.name.replace("-", "_"))


def description(model: FmuModel, fmi: int, token: str, sources: Sequence[str], kinds: Sequence[str]) -> str:
    """The text of `modelDescription.xml`; `kinds` are those of the FMU, ME and CS."""
    system = model.system
    stepping = system.stepping
    head = {"fmiVersion": f"{fmi}.0", "modelName": system.name}
    head |= {"instantiationToken" if fmi == 3 else "guid": token, "generationTool": f"vvdp {version('vvdp')}"}
    head["description"] = f"{system.name}: circuit, programs and simulation loop of vvdp"
    if fmi == 2 and ME in kinds:
        head["numberOfEventIndicators"] = str(sum(each.vector == "indicator" for each in model.inner))
    given = {"startTime": stepping.begin, "stopTime": stepping.until, "tolerance": stepping.relative_tolerance}
    given["stepSize"] = stepping.sample_period
    lines = [
        f"<fmiModelDescription {_attributes(head)}>",
        *(line for kind in (ME, CS) if kind in kinds for line in _kind_lines(kind, model, fmi, sources)),
        "  <UnitDefinitions>",
        *unit_lines(each.kind for each in model.variables),
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
    ]
    return HEAD + "\n".join(lines) + "\n"


def _kind_lines(kind: str, model: FmuModel, fmi: int, sources: Sequence[str]) -> list[str]:
    """Capabilities of a kind of FMU."""
    states = "FMUState" if fmi == 3 else "FMUstate"
    able = {"modelIdentifier": fmu_name(model), f"canGetAndSet{states}": "true", f"canSerialize{states}": "true"}
    if kind == CS:
        able |= {"canHandleVariableCommunicationStepSize": "true", **({"hasEventMode": "true"} if fmi == 3 else {})}
    elif fmi == 3:
        able["needsCompletedIntegratorStep"] = "true"
    if kind == ME and model.tangent is not None:
        able["providesDirectionalDerivatives" if fmi == 3 else "providesDirectionalDerivative"] = "true"
    if fmi == 3:
        return [f"  <{kind} {_attributes(able)}/>"]
    files = [f'      <File name="{each}"/>' for each in sources if each.endswith(".c")]
    return [f"  <{kind} {_attributes(able)}>", "    <SourceFiles>", *files, "    </SourceFiles>", f"  </{kind}>"]


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
    yield from _inner_lines(model, fmi)
    if has_clock(model, fmi):
        number = 1 + len(model.variables)
        clock = {"name": "pwm_period", "valueReference": str(number), "causality": "output"}
        clock |= {"intervalVariability": "triggered"}
        yield f'    <Clock {_attributes(clock)} description="Ticks at the first event after the end of a period"/>'
        last = {"name": "pwm_period_end", "valueReference": str(number + 1), "causality": "local"}
        last |= {"variability": "discrete", "clocks": str(number), "description": "End of the last period [s]"}
        yield _variable(fmi, last, {"unit": "s"})


def _inner_lines(model: FmuModel, fmi: int) -> Iterator[str]:
    """Variables of a guest besides: further states, rates, and for FMI 3 indicators. Rates are per second."""
    numbers = _references(model)
    states = {each.place: numbers[each.name] for each in model.carried}
    for each in model.inner:
        own = {"name": each.name, "valueReference": str(numbers[each.name]), "causality": "local"}
        own |= {"variability": "continuous", "initial": "calculated"}
        if each.vector == "rate":
            yield _variable(fmi, own, {"derivative": str(states[each.place])})
        elif each.vector == "state" or fmi == 3:
            yield _variable(fmi, own, _unit(each.kind))


def _references(model: FmuModel) -> dict[str, int]:
    return {each.name: number for number, each in enumerate(model.variables, 1)}


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
    known, needs = _references(model), _dependencies(model, fmi)
    outputs = [known[each.name] for each in model.outputs]
    rates = [known[each.name] for each in model.inner if each.vector == "rate"]
    states = [known[each.name] for each in model.inner if each.vector == "state"]
    unknown = [*outputs, *states, *rates]
    if fmi == 3:
        indicators = [known[each.name] for each in model.inner if each.vector == "indicator"]
        clocks = [1 + len(model.variables)] if has_clock(model, fmi) else []
        parts = {"Output": [*outputs, *clocks], "ContinuousStateDerivative": rates}
        parts["InitialUnknown"] = [*unknown, *clocks]
        for tag, numbers in {**parts, "EventIndicator": indicators}.items():
            told = {} if tag == "InitialUnknown" else needs
            yield from (f'    <{tag} valueReference="{number}"{told.get(number, "")}/>' for number in numbers)
        return
    for tag, numbers in {"Outputs": outputs, "Derivatives": rates, "InitialUnknowns": unknown}.items():
        if numbers:
            yield f"    <{tag}>"
            told = {} if tag == "InitialUnknowns" else needs
            yield from (f'      <Unknown index="{number}"{told.get(number, "")}/>' for number in numbers)
            yield f"    </{tag}>"


def _dependencies(model: FmuModel, fmi: int) -> dict[int, str]:
    """By reference of a rate or output of a guest, the attribute that names the states and inputs behind it."""
    if model.tangent is None:
        return {}
    known, sources = _references(model), model.tangent.sources
    references = {(Op.STATE, each.place): known[each.name] for each in model.carried}
    for each in model.settables:
        references |= {(Op.PARAMETER, own.place): known[each.name] for own in each.followers if each.role == INPUT}
    references |= {(Op.TIME, 0): 0} if fmi == 3 else {}
    rows = {"rate": 0, "output": model.tangent.rates}
    found = {}
    for shown in (*model.outputs, *model.inner):
        if shown.vector in rows:
            behind = sources[rows[shown.vector] + shown.place]
            numbers = sorted({references[one] for one in behind if one in references})
            found[known[shown.name]] = f' dependencies="{" ".join(map(str, numbers))}"'
    return found


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
