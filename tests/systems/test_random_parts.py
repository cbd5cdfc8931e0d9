"""Random circuits of one to three parts beside the same circuits written without parts."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

from vvdp.base.tables import parsed_table
from vvdp.evaluation.summary import is_closed, summary
from vvdp.simulation.run import simulate
from vvdp.simulation.values import flat
from vvdp.systems.system import System, built_system, load_system

NETWORKS, SIMULATED = 200, 6
HEAD = 'title = "Random"\n'
RUN = '[run]\nuntil = "20 ms"\n'


@dataclass(frozen=True)
class Branch:
    """Chambers in a row between two nodes; the last one is watched by a program, which nothing follows."""

    volumes: tuple[int, ...]
    areas: tuple[int, ...]
    watched: bool

    def groups(self, begin: str, end: str, prefix: str = "", volume: int | None = None) -> dict[str, list[str]]:
        """The entries of each table, with a prefix before their names and the first volume another one."""
        names = [begin, *(f"{prefix}c{i}" for i in range(len(self.volumes))), end]
        sizes = (volume or self.volumes[0], *self.volumes[1:])
        nodes = [
            f'{name} = {{ type = "volume", volume = "{size} cc", start = "10 bar" }}'
            for name, size in zip(names[1:-1], sizes, strict=True)
        ]
        components = [
            f'{prefix}r{i} = {{ type = "orifice", a = "{names[i]}", b = "{names[i + 1]}", area = "{area} mm^2" }}'
            for i, area in enumerate(self.areas)
        ]
        program = (
            f'{prefix}watch = {{ type = "unloading", pilot_pressure = "{names[-2]}.pressure", '
            'cut_out_pressure = "50 bar", cut_in_pressure = "40 bar" }'
        )
        return {"nodes": nodes, "components": components, "programs": [program] if self.watched else []}


def tables(groups: dict[str, list[str]]) -> str:
    return "".join(f"[{name}]\n" + "\n".join(entries) + "\n" for name, entries in groups.items() if entries)


def random_branch(rng: np.random.Generator) -> Branch:
    count = int(rng.integers(1, 4))
    volumes, areas = rng.integers(20, 90, count), rng.integers(2, 9, count + 1)
    return Branch(tuple(map(int, volumes)), tuple(map(int, areas)), bool(rng.random() < 0.5))


def joined(*each: dict[str, list[str]]) -> dict[str, list[str]]:
    return {name: [line for groups in each for line in groups[name]] for name in ("nodes", "components", "programs")}


def random_pair(rng: np.random.Generator, folder: Path) -> tuple[System, System]:
    """A circuit of parts, one of them perhaps within another, and the same circuit without parts."""
    main = {
        "nodes": ['tank = { type = "tank" }', 'rail = { type = "volume", volume = "60 cc", start = "20 bar" }'],
        "components": ['pump = { type = "flow-source", a = "tank", b = "rail", flow = "15 lpm" }'],
        "programs": [],
    }
    plain, uses = [main], ""
    for number in range(int(rng.integers(1, 4))):
        branch, inner = random_branch(rng), random_branch(rng)
        volume, nested = int(rng.integers(20, 90)), bool(rng.random() < 0.4)
        own = branch.groups("line", "tank")
        own["nodes"] = ['line = { type = "port" }', 'tank = { type = "port" }', *own["nodes"]]
        text = HEAD + tables(own)
        if nested:
            deeper = inner.groups("line", "out")
            deeper["nodes"] = ['line = { type = "port" }', 'out = { type = "port" }', *deeper["nodes"]]
            (folder / f"deep{number}.toml").write_text(HEAD + tables(deeper))
            text += f'[parts.deep]\nfile = "deep{number}.toml"\nline = "c0"\nout = "tank"\n'
        (folder / f"branch{number}.toml").write_text(text + '[values]\nsize = "nodes.c0.volume"\n')
        uses += f'[parts.p{number}]\nfile = "branch{number}.toml"\nline = "rail"\ntank = "tank"\nsize = "{volume} cc"\n'
        plain.append(branch.groups("rail", "tank", f"p{number}_", volume))
        if nested:
            plain.append(inner.groups(f"p{number}_c0", "tank", f"p{number}_deep_"))
    fault, dotted = '[faults.leak]\nvalue = "components.p0{}r0.area"\nbecomes = "9 mm^2"\n', rng.random() < 0.5
    faults = (fault.format("."), fault.format("_")) if dotted else ("", "")
    (folder / "main.toml").write_text(HEAD + tables(main) + uses + faults[0] + RUN)
    return load_system(str(folder / "main.toml")), built_system(
        parsed_table(HEAD + tables(joined(*plain)) + faults[1] + RUN, "plain.toml"), "plain"
    )


@pytest.mark.thorough
def test_parts_draw_the_equations_and_values_of_the_circuit_without_them(tmp_path):
    rng = np.random.default_rng(33)
    for _ in range(NETWORKS):
        drawn, plain = random_pair(rng, tmp_path)
        assert drawn.circuit.text == plain.circuit.text
        assert np.array_equal(flat(drawn.case.params), flat(plain.case.params))
        assert np.array_equal(flat(drawn.case.state), flat(plain.case.state))
        network = drawn.circuit.network
        names = [*network.nodes, *network.parts, *network.programs, *network.circuits]
        assert len(names) == len(set(names))


@pytest.mark.parametrize("seed", range(SIMULATED))
def test_balances_close_and_bits_are_the_same(tmp_path, seed):
    drawn, plain = random_pair(np.random.default_rng(seed), tmp_path)
    runs = [simulate(each.model, each.case, each.stepping) for each in (drawn, plain)]
    assert runs[0].steps == runs[1].steps
    assert np.array_equal(runs[0].final, runs[1].final)
    found = summary(drawn, runs[0])
    assert is_closed(found)
    whole = sum(value for key, value in found.items() if key in {f"loss_{p}_W" for p in drawn.circuit.network.parts})
    top = sum(found[f"loss_p{i}_W"] for i in range(3) if f"loss_p{i}_W" in found)
    assert top == pytest.approx(whole)
