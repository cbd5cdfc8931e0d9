"""Numbers that docs/models/cfd.md spells out, from the studies that are kept."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from vvdp.cfd.kept import KeptStudy, kept_study
from vvdp.cfd.refinement import grid_convergence
from vvdp.fitting.jet import jet_law

PAGE = " ".join((Path(__file__).parents[2] / "docs" / "models" / "cfd.md").read_text("utf-8").split())


def shares(study: KeptStudy, row: int) -> str:
    return " / ".join(f"{100.0 * study[f'split_{k}'][row]:.1f}" for k in (1, 2, 3)) + " %"


def cells(study: KeptStudy, row: int) -> str:
    return f"{study['cells'][row]:,.0f}".replace(",", " ")


def arms() -> Iterator[str]:
    study = kept_study("rail-arm")
    for k in range(study.rows):
        arm, drop = 1e3 * study["nozzle_arm_m"][k], 1e-5 * study["pressure_drop_Pa"][k]
        yield f"| {arm:.1f} mm | {cells(study, k)} | {drop:.2f} bar |"


def designs() -> Iterator[str]:
    study = kept_study("rail-designs")
    for k in range(study.rows):
        change = f"{100.0 * study['drop_change'][k]:+.0f} %" if k else ""
        force = f"{study['radial_force_N'][k]:.2f} N"
        yield f"| {1e-5 * study['pressure_drop_Pa'][k]:.2f} bar | {change} |".replace("  ", " ")
        yield f"| {shares(study, k)} |"
        yield f"| {force} |"


def openings() -> Iterator[str]:
    study = kept_study("openings")
    angles = np.degrees(study["spool_angle_rad"])
    for k in range(1, study.rows):
        way = "closing" if angles[k] > 0.0 else "opening"
        effective = f"{study['opening_effective'][k]:.3f} ({100.0 * study['difference'][k]:+.0f} %)"
        torques = f"{study['torque_N_m'][k]:.3f} N m | {study['torque_law_N_m'][k]:.3f} N m"
        yield f"| {abs(angles[k]):.4g}°, {way} | {study['opening_formula'][k]:.3f} | {effective} | {torques} |"
    closing, opening = (100.0 * study["difference"][k::2].mean() for k in (1, 2))
    yield f"is {-closing:.0f} % below the formula while closing and {opening:.0f} % above it while opening"
    yield f"in the mean it is {-0.5 * (closing + opening):.0f} % below"
    found = jet_law(study["opening_formula"], study["torque_N_m"], np.sign(angles))
    exponent, asymmetry = zip(found.coefficients[1:], found.half_widths[1:], strict=True)
    yield f"$s$ = {exponent[0]:.2f} ± {exponent[1]:.2f}"
    yield f"$\\varepsilon_j$ = {asymmetry[0]:.2f} ± {asymmetry[1]:.2f}"
    yield f"leave up to {100.0 * np.abs(found.residuals).max():.0f} %"
    law = study["torque_N_m"] / study["torque_law_N_m"] - 1.0
    yield f"the torque is within {100.0 * law[1::2].max():.0f} % of the law of the system"


def grids() -> Iterator[str]:
    for name, words in PARTS.items():
        study = kept_study(name)
        quantities = {"pressure_drop_Pa": (1e-5, "bar", 2), "torque_N_m": (1.0, "N m", 4)}
        for key in (key for key in quantities if key in study.columns):
            scale, unit, digits = quantities[key]
            found = grid_convergence(tuple(study["cell_size_m"][::-1]), tuple(study[key][::-1]))
            values = " / ".join(f"{scale * value:.{digits}f}" for value in study[key])
            many = " / ".join(cells(study, k) for k in range(study.rows))
            order = f"{found.order:.1f} | {100.0 * found.band:.1f} %" if found.order > 0.0 else "none |"
            order = order if found.is_monotone else "swings |"
            yield f"| {words[key]} | {many} | {values} {unit} | {order} | {100.0 * found.spread:.1f} % |"


PARTS = {
    "rail-grids": {"pressure_drop_Pa": "rail (a), drop"},
    "rail-final-grids": {"pressure_drop_Pa": "final rail, drop"},
    "centre-grids": {"pressure_drop_Pa": "centre section, total drop", "torque_N_m": "its torque"},
    "turbine-grids": {"pressure_drop_Pa": "turbine, drop", "torque_N_m": "its torque"},
}


@pytest.mark.parametrize("rows", [arms, designs, openings, grids], ids=lambda rows: rows.__name__)
def test_rows_are_those_of_the_kept_studies(rows):
    for row in rows():
        assert row in PAGE
