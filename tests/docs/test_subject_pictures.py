"""The pictures of the pages on subjects are those that their script draws."""

import re
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

DOCS = Path(__file__).parents[2] / "docs"
DIFFERENT = 0.01
"""Share of the range of a colour by which pictures may differ in the mean: fonts are set otherwise elsewhere."""


def pixels(path: Path) -> np.ndarray:
    with Image.open(path) as picture:
        return np.asarray(picture.convert("RGB"), float) / 255.0


@pytest.fixture(scope="module")
def drawn(tmp_path_factory) -> Path:
    """A folder with the pictures, drawn anew."""
    import importlib.util

    spec = importlib.util.spec_from_file_location("subject_pictures", DOCS / "site" / "subject_pictures.py")
    pictures = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(pictures)
    folder = tmp_path_factory.mktemp("subjects")
    pictures.main(folder)
    return folder


def test_the_kept_pictures_are_those_that_are_drawn(drawn):
    kept = DOCS / "images" / "subjects"
    assert {path.name for path in drawn.iterdir()} == {path.name for path in kept.iterdir()}
    for path in drawn.iterdir():
        new, old = pixels(path), pixels(kept / path.name)
        assert new.shape == old.shape
        assert np.abs(new - old).mean() < DIFFERENT, path.name
        assert np.abs(new - old[:, ::-1]).mean() > 5.0 * DIFFERENT, "a picture that is mirrored would be told"


def test_every_picture_is_shown():
    pages = "".join(path.read_text("utf-8") for path in (DOCS / "subjects").glob("*.md"))
    shown = set(re.findall(r"images/subjects/([\w-]+\.png)\)", pages))
    assert shown == {path.name for path in (DOCS / "images" / "subjects").iterdir()}
