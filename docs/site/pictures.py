"""Writes the pictures of the first page: a switched pump, the valve and a report. `python docs/site/pictures.py`

Chromium takes the picture of the report.
"""

import io
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
from PIL import Image

import vvdp
from vvdp.base.units import ATMOSPHERE
from vvdp.results.chart import Colour

IMAGES = Path(__file__).parents[1] / "images"
WIDTH, PAGE_HEIGHT = 1100, 1500
"""What is shown of a page [px]."""
COLOURS = 256


def main(folder: Path = IMAGES) -> None:
    """Writes switched-pump.png, valve.png and report.png into `folder`."""
    (folder / "switched-pump.png").write_bytes(switched_pump())
    browser = shutil.which("chromium") or sys.exit("Chromium is not installed; it takes the pictures")
    with tempfile.TemporaryDirectory() as place:
        work = Path(place)
        vvdp = [sys.executable, "-m", "vvdp"]
        subprocess.run([*vvdp, "geometry", "prototype", "--frames", "0", "--out", "valve"], check=True, cwd=work)
        subprocess.run([*vvdp, "run", "prototype"], check=True, cwd=work)
        (report,) = work.glob("results/*/report.html")
        drawing = (work / "valve" / "figures" / "solids.svg").read_text("utf-8")
        across, high = map(float, re.search(r'viewBox="0 0 ([\d.]+) ([\d.]+)"', drawing).groups())  # type: ignore[union-attr]
        page = work / "valve.html"
        page.write_text(
            f'<body style="margin:0"><style>svg {{ width: {WIDTH}px; height: auto; display: block }}</style>{drawing}',
            "utf-8",
        )
        (folder / "valve.png").write_bytes(screen(browser, page, round(WIDTH * high / across), work))
        (folder / "report.png").write_bytes(screen(browser, report, PAGE_HEIGHT, work))


SHOWN = 0.028
"""How much of the run's end is shown [s]."""


def switched_pump() -> bytes:
    """Two periods of the prototype: what the ports do, the pressures, and where the pump's power goes."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    run = vvdp.load("prototype", run={"until": "0.75 s", "window": "0.06 s", "window_interval": "20 us"}).run()
    series = run.to_pandas().loc[0.75 - SHOWN :]
    t = 1e3 * (series.index.to_numpy() - series.index[0])
    out = {name.removeprefix("outputs."): series[name].to_numpy() for name in series if name.startswith("outputs.")}
    inlet, load = (series[f"states.{name}_Pa"].to_numpy() - ATMOSPHERE for name in ("inlet", "load_line"))
    pump = 1e-3 * inlet * out["pump_flow_m3_s"]
    useful = 1e-3 * load * np.clip(out["valve_load_flow_m3_s"], 0.0, None)
    relief = 1e-3 * inlet * out["relief_valve_flow_m3_s"]
    valve = np.clip(pump - useful - relief, 0.0, None)

    figure, (ports, pressures, powers) = plt.subplots(3, 1, figsize=(9.0, 6.4), sharex=True, height_ratios=(1, 2, 2.4))
    for name, label, colour in (("load", "to the load", Colour.LOAD), ("tank", "to the tank", Colour.TANK)):
        ports.fill_between(t, out[f"valve_{name}_opening"], color=colour, alpha=0.75, linewidth=0.0, label=label)
    pressures.plot(t, 1e-5 * inlet, color=Colour.INLET, label="pump")
    pressures.plot(t, 1e-5 * load, color=Colour.LOAD, label="load")
    parts = (("reaches the load", Colour.LOAD), ("valve", Colour.INLET), ("relief valve", Colour.RED))
    powers.stackplot(
        t, useful, valve, relief, labels=[name for name, _ in parts], colors=[c for _, c in parts], alpha=0.85
    )
    for axis, label in ((ports, "port open"), (pressures, "pressure [bar]"), (powers, "power [kW]")):
        axis.set_ylabel(label)
        axis.set_xlim(t[0], t[-1])
        axis.set_ylim(bottom=0.0)
        axis.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0), frameon=False)
        axis.spines[["top", "right"]].set_visible(False)
    powers.set_xlabel("time [ms]")
    figure.align_ylabels()
    figure.tight_layout()
    out_file = io.BytesIO()
    figure.savefig(out_file, format="png", dpi=110, metadata={"Software": None})
    return out_file.getvalue()


def screen(browser: str, page: Path, height: int, work: Path) -> bytes:
    """The upper `height` pixels of a page as PNG, in few colours."""
    taken = work / "screen.png"
    shape = [f"--screenshot={taken}", f"--window-size={WIDTH},{height}", "--hide-scrollbars"]
    options = ["--headless", "--no-sandbox", "--disable-gpu", "--virtual-time-budget=5000"]
    subprocess.run([browser, *options, *shape, page.as_uri()], check=True)
    out = io.BytesIO()
    with Image.open(taken) as picture:
        picture.convert("RGB").quantize(COLOURS, Image.Quantize.MAXCOVERAGE, dither=Image.Dither.NONE).save(
            out, "PNG", optimize=True
        )
    return out.getvalue()


if __name__ == "__main__":
    main()
