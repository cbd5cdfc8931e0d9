"""Graphs of circuits that diagrams are drawn of."""

from vvdp.network.graph import Graph, GraphComponent, GraphNode, NodeKind

V, Z, T, P = NodeKind.VOLUME, NodeKind.ACCUMULATOR, NodeKind.TANK, NodeKind.PRESSURE
SHAFT, MOTOR, ROD = NodeKind.SHAFT, NodeKind.DRIVEN_SHAFT, NodeKind.ROD
Node, Part = GraphNode, GraphComponent
TANK = Node("tank", T)


def prototype(load_is_source: bool = False) -> Graph:
    load_line = Node("load line", P if load_is_source else Z, ("60 bar",) if load_is_source else ("0.5 L gas",))
    nodes = (
        Node("inlet", V, ("12.7 cm³",)),
        load_line,
        TANK,
        Node("pump shaft", MOTOR, ("1800 rpm",)),
        Node("spool", SHAFT),
        Node("motor shaft", MOTOR),
    )
    parts = [
        Part("pump", "pump", {"suction": "tank", "outlet": "inlet", "shaft": "pump shaft"}, labels=("22.22 cm³/rev",)),
        Part("relief valve", "relief_valve", {"inlet": "inlet", "tank": "tank"}, labels=("100 bar",)),
        Part(
            "valve",
            "rotary_valve",
            {"inlet": "inlet", "load": "load line", "tank": "tank", "spool": "spool"},
            {"axial_position": "AXIAL"},
            labels=("3 sections",),
        ),
        Part("drive", "coupling", {"motor": "motor shaft", "spool": "spool"}),
    ]
    if not load_is_source:
        parts.append(Part("load", "orifice", {"inlet": "load line", "outlet": "tank"}, labels=("6.2 mm²",)))
    return Graph("Prototype", nodes, tuple(parts))


def buck() -> Graph:
    nodes = (Node("supply", P, ("200 bar",)), Node("switched", V), Node("load", V, ("1 L",)), TANK)
    parts = (
        Part("switch", "valve_3_2", {"P": "supply", "A": "switched", "T": "tank"}, {"duty": "pwm.duty"}),
        Part("check", "check_valve", {"inlet": "tank", "outlet": "switched"}),
        Part("inertance", "line", {"inlet": "switched", "outlet": "load"}, labels=("1.7 m × 7 mm",)),
        Part("load orifice", "orifice", {"inlet": "load", "outlet": "tank"}),
    )
    return Graph("Buck converter", nodes, parts)


def boost() -> Graph:
    nodes = (Node("supply", V), Node("switched", V), Node("load", Z, ("2 L",)), TANK)
    parts = (
        Part("source", "flow_source", {"outlet": "supply"}),
        Part("inertance", "line", {"a": "supply", "b": "switched"}),
        Part("switch", "valve_2_2", {"inlet": "switched", "outlet": "tank"}, {"u": "PWM"}),
        Part("check", "check_valve", {"inlet": "switched", "outlet": "load"}),
        Part("load orifice", "adjustable_orifice", {"inlet": "load", "outlet": "tank"}, {"area": "step"}),
    )
    return Graph("Boost converter", nodes, parts)


def charging() -> Graph:
    nodes = (
        Node("delivery", V),
        Node("store", Z, ("10 L, 90 bar",)),
        Node("cap", V),
        Node("rod side", V),
        TANK,
        Node("engine", MOTOR, ("1500 rpm",)),
        Node("slide", ROD, ("120 kg",)),
    )
    parts = (
        Part("pump", "pump", {"suction": "tank", "outlet": "delivery", "shaft": "engine"}),
        Part("unloading", "unloading_valve", {"inlet": "delivery", "outlet": "tank", "pilot": "store"}),
        Part("check", "check_valve", {"inlet": "delivery", "outlet": "store"}),
        Part("valve", "valve_4_3", {"P": "store", "T": "tank", "A": "cap", "B": "rod side"}, {"u": "controller.u"}),
        Part("cylinder", "cylinder", {"cap": "cap", "rod": "rod side", "slide": "slide"}, labels=("40/28 × 400 mm",)),
        Part("friction", "friction", {"slide": "slide"}),
        Part("stop", "end_stop", {"slide": "slide"}),
        Part("weight", "force", {"slide": "slide"}, {"force": "LOAD"}),
    )
    return Graph("Accumulator charging", nodes, parts)


def two_pumps() -> Graph:
    nodes = (
        Node("left", V), Node("right", V), TANK, Node("left motor", MOTOR), Node("right motor", MOTOR),
    )  # fmt: skip
    parts = (
        Part("left pump", "pump", {"suction": "tank", "outlet": "left", "shaft": "left motor"}),
        Part("right pump", "pump", {"suction": "tank", "outlet": "right", "shaft": "right motor"}),
        Part("hose", "hose", {"inlet": "left", "outlet": "right"}, labels=("25 m × 19 mm",)),
        Part("left relief", "relief_valve", {"inlet": "left", "outlet": "tank"}, labels=("200 bar",)),
        Part("throttle", "adjustable_orifice", {"inlet": "right", "outlet": "tank"}),
    )
    return Graph("Two pumps with a long hose", nodes, parts)


def transmission() -> Graph:
    nodes = (
        Node("high", V), Node("low", V), Node("charge", V), TANK, Node("engine", MOTOR, ("2000 rpm",)),
        Node("wheel", SHAFT, ("2 kg·m²",)),
    )  # fmt: skip
    parts = (
        Part("pump", "pump", {"a": "low", "b": "high", "shaft": "engine"}),
        Part("charge pump", "pump", {"suction": "tank", "outlet": "charge", "shaft": "engine"}),
        Part("motor", "hydraulic_motor", {"inlet": "high", "outlet": "low", "shaft": "wheel"}),
        Part("drag", "torque", {"shaft": "wheel"}),
        Part("relief high", "relief_valve", {"inlet": "high", "outlet": "low"}, labels=("350 bar",)),
        Part("relief low", "relief_valve", {"inlet": "low", "outlet": "high"}, labels=("350 bar",)),
        Part("check high", "check_valve", {"inlet": "charge", "outlet": "high"}),
        Part("check low", "check_valve", {"inlet": "charge", "outlet": "low"}),
        Part("charge relief", "relief_valve", {"inlet": "charge", "outlet": "tank"}, labels=("20 bar",)),
    )
    return Graph("Hydrostatic transmission", nodes, parts)


def every_symbol() -> Graph:
    """All two-port symbols side by side, a few others and one that nobody knows."""
    names = (
        "orifice", "adjustable_orifice", "two_orifices", "relief_valve", "unloading_valve", "reducing_valve",
        "flow_control", "check_valve", "pilot_check_valve", "valve_2_2", "proportional_valve_2_2", "hose",
    )  # fmt: skip
    nodes = (
        Node("supply", P), Node("output", V), TANK, Node("rod", ROD), Node("drive", NodeKind.DRIVEN_ROD),
        Node("flap <1>", SHAFT),
    )  # fmt: skip
    parts = [Part(f"the {name}", name, {"inlet": "supply", "outlet": "output"}) for name in names]
    parts += [
        Part("own", "my & valve", {"in": "supply", "out": "output", "drain": "tank", "lever": "flap <1>"}),
        Part("sensor", "sensor", {"port": "output"}),
        Part("return", "spring_cylinder", {"chamber": "output", "rod_end": "rod"}),
        Part("spring", "spring", {"left": "rod", "right": "drive"}),
    ]
    return Graph("Every symbol", nodes, tuple(parts))


CIRCUITS = {
    "prototype": prototype(),
    "pressure load": prototype(True),
    "buck": buck(),
    "boost": boost(),
    "charging": charging(),
    "two pumps": two_pumps(),
    "transmission": transmission(),
    "every symbol": every_symbol(),
}
