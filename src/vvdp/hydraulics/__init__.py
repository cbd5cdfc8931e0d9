"""Components between the oil and the circuit: orifices, volumes, pumps, valves, lines, cylinders, drives."""
