"""A part in the diagram: one box with its ports, and a drawing of what is in it."""

from vvdp.base.tables import parsed_table
from vvdp.report.circuit import graph_of
from vvdp.report.diagram import diagram
from vvdp.systems.system import built_system, load_system, source_text


def test_a_part_is_one_component_and_has_a_drawing_of_its_own():
    network = load_system("two-cylinders").circuit.network
    whole = graph_of(network, "two-cylinders")
    assert {each.name for each in whole.components} == {
        *("lift_unit", "lift", "swing_unit", "swing", "lift_valve", "swing_valve")
    }
    assert whole.component("lift_unit").ports == {"load": "lift_line", "tank": "tank", "shaft": "motor"}
    assert not [node.name for node in whole.nodes if node.name.startswith("lift_unit_")]
    inner = graph_of(network, "lift unit", "lift_unit")
    assert {each.name for each in inner.components} == {
        *("lift_unit_pump", "lift_unit_relief_valve", "lift_unit_valve")
    }
    assert {each.name for each in inner.nodes} == {"lift_line", "tank", "motor", "lift_unit_inlet", "lift_unit_spool"}
    assert '<a href="#figure-circuit-lift_unit">' in diagram(whole)
    assert "<a " not in diagram(inner)


def test_what_a_fault_joins_to_a_part_is_drawn_in_it():
    text = source_text("two-cylinders") + '[faults.seized]\njams = "lift.rod"\nforce = "50 kN"\nbegin = "0.3 s"\n'
    network = built_system(parsed_table(text, "my.toml"), "my").circuit.network
    assert "seized" not in {each.name for each in graph_of(network, "whole").components}
    assert "seized" in {each.name for each in graph_of(network, "lift", "lift").components}
