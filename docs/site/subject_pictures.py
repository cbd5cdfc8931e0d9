"""Draws the pictures of the pages on subjects that no other page has. `python docs/site/subject_pictures.py`"""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

from vvdp.evaluation.bench import RotaryBench, rotary_bench
from vvdp.results.chart import Colour
from vvdp.systems.system import load_system
from vvdp.valve.flow_map import delivered_flows
from vvdp.valve.geometry import port_openings
from vvdp.valve.operating_point import operating_point

FOLDER = Path(__file__).parents[1] / "images" / "subjects"
BAR, LPM = 1e5, 1.0 / 6e4
LOADS = {20: Colour.TANK, 60: Colour.LOAD, 100: Colour.INLET}
"""Load pressures over which the delivered flow is drawn [bar], with their colours."""
DUTIES = (0.15, 0.5, 0.85)
PRESSURES = np.linspace(10.0, 100.0, 19)
"""Load pressures over which losses are drawn [bar]."""
PARTS = {
    "open valve": ("full_open_loss", Colour.LOAD),
    "transitions": ("transition_loss", Colour.INLET),
    "compression": ("compressibility_loss", Colour.GREEN),
    "leakage": ("leakage_loss", Colour.PURPLE),
}


def prototype() -> RotaryBench:
    """The bench of the shipped prototype."""
    return rotary_bench(load_system("prototype"), "pictures")


def valve_ports() -> Any:
    """Open fractions over a period at three duty ratios; below, the mean flow to the load over the duty ratio."""
    bench = prototype()
    valve = bench.valve
    figure = plt.figure(figsize=(9.0, 6.2), layout="constrained")
    rows = figure.add_gridspec(2, 3, height_ratios=(1, 1.9))
    turn = np.linspace(0.0, 1.0, 601)
    for column, duty in enumerate(DUTIES):
        axis = figure.add_subplot(rows[0, column])
        open_ = port_openings(turn * 2.0 * np.pi / valve.sections, duty * valve.helix_length, valve)
        axis.fill_between(turn, open_.load, color=Colour.LOAD, alpha=0.8, linewidth=0.0, label="load")
        axis.fill_between(turn, open_.tank, color=Colour.TANK, alpha=0.6, linewidth=0.0, label="tank")
        axis.set(title=f"duty ratio {duty:g}", xlabel="time over period", xlim=(0.0, 1.0), ylim=(0.0, 1.05))
        if column == 0:
            axis.set_ylabel("open fraction")
    axis.legend(frameon=False, loc="upper left", bbox_to_anchor=(1.0, 1.0))
    below = figure.add_subplot(rows[1, :])
    duties = np.linspace(0.0, 1.0, 101)
    at = bench.unit.set_point(0.0).condition(bench.oil)
    below.plot(duties, duties * at.flow / LPM, color=Colour.RELIEF, linestyle=":", label="ideal switch")
    for load, colour in LOADS.items():
        against = at._replace(load_pressure=load * BAR + bench.tank_pressure)
        below.plot(duties, delivered_flows(duties, against, valve) / LPM, color=colour, label=f"{load} bar")
    below.set(xlabel="duty ratio", ylabel="mean flow to the load [lpm]", xlim=(0.0, 1.0), ylim=(0.0, None))
    below.legend(frameon=False)
    return figure


def losses() -> Any:
    """What the valve loses by kind over the load pressure, with a fixed relief setting and with one 20 % above."""
    bench = prototype()
    tank = bench.tank_pressure
    figure, axes = plt.subplots(1, 2, figsize=(9.0, 3.6), sharey=True, layout="constrained")
    for axis, title, setting in (
        (axes[0], "relief valve at 120 bar", lambda load: 120.0),
        (axes[1], "relief valve 20 % above the load", lambda load: 1.2 * load),
    ):
        points = []
        for load in PRESSURES:
            point = bench.unit.set_point(load * BAR + tank)._replace(relief_pressure=setting(load) * BAR + tank)
            points.append(operating_point(point, bench.inlet_volume, bench.oil, bench.valve))
        parts = [[1e-3 * getattr(point, key) for point in points] for key, _ in PARTS.values()]
        colours = [colour for _, colour in PARTS.values()]
        axis.stackplot(PRESSURES, parts, labels=list(PARTS), colors=colours, alpha=0.85)
        axis.set(title=title, xlabel="load pressure [bar]", xlim=(PRESSURES[0], PRESSURES[-1]), ylim=(0.0, None))
    axes[0].set_ylabel("loss [kW]")
    axes[1].legend(frameon=False, loc="upper left", reverse=True)
    return figure


PICTURES: dict[str, Callable[[], Any]] = {"valve-ports": valve_ports, "losses": losses}


def main(folder: Path = FOLDER) -> None:
    """Writes all of them as PNG."""
    folder.mkdir(parents=True, exist_ok=True)
    for name, draw in PICTURES.items():
        figure = draw()
        for axis in figure.axes:
            axis.spines[["top", "right"]].set_visible(False)
        figure.savefig(folder / f"{name}.png", dpi=110, metadata={"Software": None})
        plt.close(figure)


if __name__ == "__main__":
    main()
