"""Description of a foreign FMU: it is text from anyone, read without running anything."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from fractions import Fraction
from typing import NamedTuple
from xml.parsers import expat

from vvdp.base.errors import ParameterError

INPUT, OUTPUT, PARAMETER = "input", "output", "parameter"
REAL = {2: "Real", 3: "Float64"}
"""The type of variables that are exchanged, by the version of FMI."""
BASE = ("kg", "m", "s", "K")
FOREIGN_BASE = ("A", "mol", "cd")


class FmuUnit(NamedTuple):
    """A unit as an FMU describes it: SI value = factor * value + offset, powers of kg, m, s, K, and of the radian."""

    factor: float
    offset: float
    powers: tuple[Fraction, ...]
    angle: int


class Variable(NamedTuple):
    """A variable: its type, reference, causality, name of its unit (empty: none) and start value (None: not given)."""

    name: str
    type: str
    reference: int
    causality: str
    variability: str
    unit: str
    start: float | None
    is_array: bool


@dataclass(frozen=True)
class Description:
    """The parts of a description that an importer needs; `units` are those with base units."""

    fmi: int
    model: str
    identifier: str
    token: str
    tool: str
    features: Mapping[str, str]
    kinds: tuple[str, ...]
    units: Mapping[str, FmuUnit]
    variables: Mapping[str, Variable]

    def has(self, feature: str) -> bool:
        """Whether co-simulation has a feature, by the name of its attribute."""
        return self.features.get(feature, "false") in ("true", "1")


class _Element(NamedTuple):
    path: tuple[str, ...]
    attributes: Mapping[str, str]


def read_description(text: bytes) -> Description:
    """The description in `modelDescription.xml`. Raises ParameterError with its fault."""
    elements = _elements(text)
    if not elements or elements[0].path != ("fmiModelDescription",):
        raise ParameterError("the description is not that of an FMU; expected the element fmiModelDescription")
    head = elements[0].attributes
    version = head.get("fmiVersion", "").partition(".")[0]
    if version not in ("2", "3"):
        raise ParameterError(f"the FMU is of FMI version {head.get('fmiVersion', '(none)')!r}; expected 2 or 3")
    fmi = int(version)
    below = [(each.path[1:], each.attributes) for each in elements[1:]]
    kinds = tuple(path[0] for path, _ in below if path[0] in ("CoSimulation", "ModelExchange", "ScheduledExecution"))
    features = next((found for path, found in below if path == ("CoSimulation",)), {})
    return Description(
        fmi=fmi,
        model=head.get("modelName", ""),
        identifier=features.get("modelIdentifier", ""),
        token=head.get("guid" if fmi == 2 else "instantiationToken", ""),
        tool=head.get("generationTool", ""),
        features=features,
        kinds=tuple(dict.fromkeys(kinds)),
        units=_units(below),
        variables=(_variables2 if fmi == 2 else _variables3)(below, _type_units(below)),
    )


def _elements(text: bytes) -> list[_Element]:
    """The elements of an XML text in their order. Document types are refused: their entities may grow without end."""
    found, path = list[_Element](), list[str]()
    parser = expat.ParserCreate()

    def begin(name: str, attributes: dict[str, str]) -> None:
        path.append(name)
        found.append(_Element(tuple(path), attributes))

    def refuse(*_: object) -> None:
        raise ParameterError("the description has a document type (DOCTYPE); it is not read")

    parser.StartElementHandler = begin
    parser.EndElementHandler = lambda _: path.pop()
    parser.StartDoctypeDeclHandler = refuse
    try:
        parser.Parse(text, True)
    except expat.ExpatError as problem:
        raise ParameterError(f"the description is not well-formed XML ({problem})") from None
    return found


_Below = list[tuple[tuple[str, ...], Mapping[str, str]]]


def _units(below: _Below) -> dict[str, FmuUnit]:
    found, name = dict[str, FmuUnit](), ""
    for path, given in below:
        if path == ("UnitDefinitions", "Unit"):
            name = given.get("name", "")
        elif path == ("UnitDefinitions", "Unit", "BaseUnit") and not any(_whole(given, key) for key in FOREIGN_BASE):
            found[name] = FmuUnit(
                _number(given, "factor", 1.0) or 0.0,
                _number(given, "offset", 0.0) or 0.0,
                tuple(Fraction(_whole(given, key)) for key in BASE),
                _whole(given, "rad"),
            )
    return found


def _type_units(below: _Below) -> dict[str, str]:
    """The unit of each declared type."""
    found, name = dict[str, str](), ""
    for path, given in below:
        if path[:1] != ("TypeDefinitions",):
            continue
        name = given.get("name", name)
        if "unit" in given:
            found[name] = given["unit"]
    return found


def _variables2(below: _Below, types: Mapping[str, str]) -> dict[str, Variable]:
    found, head = dict[str, Variable](), dict[str, str]()
    for path, given in below:
        if path == ("ModelVariables", "ScalarVariable"):
            head = dict(given)
        elif path[:2] == ("ModelVariables", "ScalarVariable") and len(path) == 3 and path[2] != "Annotations":
            _add(found, path[2], {**given, **head}, types)
    return found


def _variables3(below: _Below, types: Mapping[str, str]) -> dict[str, Variable]:
    found, last = dict[str, Variable](), ""
    for path, given in below:
        if path[:1] == ("ModelVariables",) and len(path) == 2:
            last = _add(found, path[1], given, types)
        elif path[:1] == ("ModelVariables",) and path[-1] == "Dimension" and last in found:
            found[last] = found[last]._replace(is_array=True)
    return found


def _add(found: dict[str, Variable], kind: str, given: Mapping[str, str], types: Mapping[str, str]) -> str:
    name = given.get("name", "")
    found[name] = Variable(
        name=name,
        type=kind,
        reference=_whole(given, "valueReference"),
        causality=given.get("causality", "local"),
        variability=given.get("variability", "continuous"),
        unit=given.get("unit", types.get(given.get("declaredType", ""), "")),
        start=_number(given, "start", None) if kind in REAL.values() else None,
        is_array=False,
    )
    return name


def _read_attribute(read: Callable[[str], float], given: Mapping[str, str], key: str, expected: str) -> float:
    try:
        return read(given[key])
    except ValueError:
        raise ParameterError(f"the description has {key} = {given[key]!r}; expected {expected}") from None


def _number(given: Mapping[str, str], key: str, usual: float | None) -> float | None:
    return _read_attribute(float, given, key, "a number") if key in given and " " not in given[key] else usual


def _whole(given: Mapping[str, str], key: str) -> int:
    return int(_read_attribute(int, given, key, "a whole number")) if key in given else 0
