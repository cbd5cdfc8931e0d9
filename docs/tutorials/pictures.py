"""Draws the pictures of the tutorial: runs its blocks and takes what they leave. `python docs/tutorials/pictures.py`"""

import re
import sys
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from vvdp.report.drawing import INK, INLET, LOAD, RELIEF, TANK, image, legend

HERE = Path(__file__).parent
PAGE = HERE / "speed-from-a-bad-encoder.md"


def methods(figure: Any, found: dict[str, Any]) -> None:
    """Speed by counting, by timing and by the filter."""
    time, at, begin, end = found["time"], found["at"], 0.5, 0.8
    panels = figure.subplots(3, 1, sharex=True, sharey=True)
    tracks = (
        ("counting, 20 samples", time[20:], found["by_counting"], RELIEF),
        ("timing, edge to edge", time[at[1:]], found["by_timing"], TANK),
        ("filter", found["edge_times"], np.array(found["speeds"]), INLET),
    )
    for axes, (name, moments, speeds, colour) in zip(panels, tracks, strict=True):
        part = (moments > begin - 0.01) & (moments < end + 0.01)
        axes.axhline(found["true_speed"], color=INK, linewidth=0.8, linestyle=(0, (4, 2)))
        axes.step(moments[part], speeds[part], where="post", color=colour, linewidth=1.2)
        axes.set_title(name, loc="left", pad=3.0)
        axes.set_xlim(begin, end)
        axes.set_ylim(105.0, 210.0)
    panels[1].set_ylabel("speed [rad/s]")
    panels[-1].set_xlabel("time [s]")


def manoeuvre(figure: Any, found: dict[str, Any]) -> None:
    """The step as the patient, the nimble and the alert filter see it."""
    axes, time = figure.subplots(1, 1), found["time"]
    part = (time > 0.95) & (time < 1.4)
    axes.plot(time[part], found["truth"][part], color=INK, linewidth=1.8, label="true")
    looks = (("patient", TANK, (0, (4, 1.5))), ("nimble", LOAD, (0, (1, 1))), ("alert", INLET, "-"))
    settings = (found["patient"], found["nimble"], found["estimator"].settings)
    for (name, colour, style), values in zip(looks, settings, strict=True):
        _, speed, _ = found["estimated"](found["rows"], values)
        axes.plot(time[part], speed[part], color=colour, linestyle=style, linewidth=1.4, label=name)
    axes.set_xlim(0.95, 1.4)
    axes.set_xlabel("time [s]")
    axes.set_ylabel("speed [rad/s]")
    legend(axes, 4)


PICTURES = (("error", 3.6, methods), ("nimble", 2.6, manoeuvre))
"""What a block must have left before a picture is drawn, its height in inches, and what draws it."""


def main(folder: Path = HERE) -> None:
    """Runs the page block by block and writes its pictures into `folder`."""
    found: dict[str, Any] = {}
    waiting = dict(enumerate(PICTURES, 1))
    for block in re.findall(r"```python\n(.*?)```", PAGE.read_text("utf-8"), re.DOTALL):
        exec(block, found)
        for number, (needed, height, draw) in list(waiting.items()):
            if needed in found:
                name = f"{PAGE.stem}-{number}"
                (folder / f"{name}.png").write_bytes(image(name, height, partial(draw, found=found), "png"))
                del waiting[number]
        if not waiting:
            return
    sys.exit(f"{PAGE.name} leaves nothing for the pictures {list(waiting)}")


if __name__ == "__main__":
    main()
