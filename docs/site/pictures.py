"""Writes the pictures of the first page: the valve and a report. `python docs/site/pictures.py` (needs Chromium)"""

import io
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

from PIL import Image

IMAGES = Path(__file__).parents[1] / "images"
REPORT_SIZE = (1100, 1500)
"""What is shown of the page [px]."""
COLOURS = 128


def main(folder: Path = IMAGES) -> None:
    """Writes valve.png and report.png into `folder`."""
    browser = shutil.which("chromium") or sys.exit("Chromium is not installed; it takes the picture of the report")
    with tempfile.TemporaryDirectory() as place:
        work = Path(place)
        vvdp = [sys.executable, "-m", "vvdp"]
        subprocess.run([*vvdp, "geometry", "prototype", "--frames", "0", "--out", str(work / "valve")], check=True)
        subprocess.run([*vvdp, "run", "prototype", "--out", str(work / "run")], check=True)
        size = ",".join(map(str, REPORT_SIZE))
        taken = [f"--screenshot={work / 'report.png'}", f"--window-size={size}", "--hide-scrollbars"]
        options = ["--headless", "--no-sandbox", "--disable-gpu", "--virtual-time-budget=5000"]
        subprocess.run([browser, *options, *taken, (work / "run" / "report.html").as_uri()], check=True)
        for source, name in ((work / "valve" / "figures" / "solids.png", "valve"), (work / "report.png", "report")):
            (folder / f"{name}.png").write_bytes(small(source))


def small(path: Path) -> bytes:
    """A picture in few colours."""
    out = io.BytesIO()
    picture = Image.open(path).convert("RGB").quantize(COLOURS, dither=Image.Dither.NONE)
    picture.save(out, "PNG", optimize=True)
    return out.getvalue()


if __name__ == "__main__":
    main()
