"""Numbers that docs/models/cfd.md spells out, from the studies that are kept."""

import re
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from vvdp.cfd.kept import KeptStudy, kept_study
from vvdp.cfd.refinement import grid_convergence
from vvdp.numerics.least_squares import fit

PAGE = " ".join((Path(__file__).parents[2] / "docs" / "models" / "cfd.md").read_text("utf-8").split())
RADIUS = 12.7e-3


def shares(study: KeptStudy, row: int) -> str:
    return " / ".join(f"{100.0 * study[f'split_{k}'][row]:.1f}" for k in (1, 2, 3)) + " %"


def cells(study: KeptStudy, row: int) -> str:
    return f"{study['cells'][row]:,.0f}".replace(",", " ")


def arms() -> Iterator[str]:
    study = kept_study("rail-arm")
    for k in range(study.rows):
        yield f"| {1e3 * study['nozzle_arm_m'][k]:.1f} mm | {cells(study, k)} | {1e-5 * study['pressure_drop_Pa'][k]:.2f} bar |"


def designs() -> Iterator[str]:
    study = kept_study("rail-designs")
    for k in range(study.rows):
        change = f"{100.0 * study['drop_change'][k]:+.0f} %" if k else ""
        force = f"{study['radial_force_N'][k]:.2f} N"
        yield f"| {1e-5 * study['pressure_drop_Pa'][k]:.2f} bar | {change} |".replace("  ", " ")
        yield f"| {shares(study, k)} |"
        yield f"| {force} |"


@pytest.mark.parametrize("rows", [arms, designs], ids=lambda rows: rows.__name__)
def test_rows_are_those_of_the_kept_studies(rows):
    for row in rows():
        assert row in PAGE
