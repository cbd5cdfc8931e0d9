"""Writes the pictures of the first page: the valve and a report. `python docs/site/pictures.py` (needs Chromium)"""

import io
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

from PIL import Image

IMAGES = Path(__file__).parents[1] / "images"
WIDTH, PAGE_HEIGHT = 1100, 1500
"""What is shown of a page [px]."""
COLOURS = 256


def main(folder: Path = IMAGES) -> None:
    """Writes valve.png and report.png into `folder`."""
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
