"""The tutorial on writing a circuit: its code runs, and its numbers are those of an independent calculation."""

import math
import re
import runpy
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

PAGE = Path(__file__).parents[2] / "docs" / "own-circuit.md"


@pytest.fixture(scope="module")
def tutorial(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    """What the blocks of the page leave, run in order as one module; `printed` is what they said."""
    folder = tmp_path_factory.mktemp("own")
    program = folder / "own_circuit.py"
    program.write_text("\n".join(re.findall(r"```python\n(.*?)```", PAGE.read_text("utf-8"), re.DOTALL)))
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        patch.setattr(sys, "argv", [str(program)])
        return runpy.run_path(str(program)) | {"folder": folder}


def by_hand() -> tuple[float, float, float, float]:
    """Mean load pressure over the last 45 periods, highest inlet pressure, and both pressures at the end [Pa].

    Nothing of vvdp is used: the circuit is written down again in its own words and solved by SciPy, restarted at
    every edge of the pulse train and where the spool meets an end of its stroke.
    """
    P0, phi, n, b, rho = 101325.0, 0.01, 1.4, 1.4e9, 870.0
    Q, V_in, V_load, A_load, A_full, cd, eps = 20e-3 / 60, 20e-6, 200e-6, 4.7e-6, 30e-6, 0.61, 5e3
    omega, zeta, stroke, lap, f = 2 * math.pi * 200.0, 0.7, 1e-3, -1e-4, 75.0

    def fluid(P: float) -> tuple[float, float]:
        air, liquid = phi * (P / P0) ** (-1 / n), (1 - phi) * math.exp((P0 - P) / b)
        return air + liquid, (air + liquid) / (air / (n * P) + liquid / b)

    def mass(area: float, Pa: float, Pb: float) -> float:
        dp = Pa - Pb
        flow = cd * area * math.sqrt(2 / rho) * dp / (dp * dp + eps * eps) ** 0.25
        return flow / fluid(Pa if dp > 0 else Pb)[0]

    def rates(t: float, y: Any, on: float, held: bool) -> list[float]:
        P, L, x, v, _ = y
        opening = [min(max((side * (x - stroke / 2) - lap) / (stroke / 2 - lap), 0.0), 1.0) for side in (1, -1)]
        nu, beta = fluid(P)
        nu_load, beta_load = fluid(L)
        to_load, to_tank = mass(A_full * opening[0], P, L), mass(A_full * opening[1], P, P0)
        pull = omega**2 * (on * stroke - x) - 2 * zeta * omega * v
        return [
            beta / V_in * nu * (Q - to_load - to_tank),
            beta_load / V_load * nu_load * (to_load - mass(A_load, L, P0)),
            0.0 if held else v,
            pull - 50 * omega * v if held else pull,
            L,
        ]

    def meets(t: float, y: Any, on: float, held: bool) -> float:
        return float(y[2] - stroke if on else y[2])  # the end of the stroke that the spool travels to

    y = np.array([5e5 + P0, 10e5 + P0, 0.0, 0.0, 0.0])
    t, highest, before = 0.0, 0.0, 0.0
    for half in range(150):
        edge, on, held = (half + 1) / (2 * f), float(half % 2 == 0), False
        if half == 60:
            before = y[4]
        # Pulled on by the command, a spool that has met the end stays there until it is called back at the next edge.
        meets.terminal, meets.direction = True, 1.0 if on else -1.0  # type: ignore[attr-defined]
        while t < edge:
            found = solve_ivp(
                rates,
                (t, edge),
                y,
                method="LSODA",
                args=(on, held),
                rtol=1e-9,
                atol=[1.0, 1.0, 1e-12, 1e-9, 1e-3],
                events=None if held else meets,
                dense_output=True,
            )
            assert found.success
            # The highest of a solver's steps lies below the peak between them: look there with its own polynomial.
            near = int(found.y[0].argmax())
            around = np.linspace(found.t[max(near - 1, 0)], found.t[min(near + 1, found.t.size - 1)], 2001)
            highest = max(highest, found.sol(around)[0].max())
            y, t = found.y[:, -1], found.t[-1]
            held = t < edge
        t = edge
    return (y[4] - before) / 0.6, highest, y[0], y[1]


def test_the_page_runs_and_says_what_it_found(tutorial: dict[str, Any]) -> None:
    assert (tutorial["folder"] / "own-circuit.png").stat().st_size > 10_000
    assert tutorial["books"].is_trusted
    assert abs(tutorial["books"].mass_residual) < 1e-7
    assert tutorial["run"].finished and tutorial["run"].end == 1.0


def test_an_independent_calculation_agrees(tutorial: dict[str, Any]) -> None:
    mean, highest, inlet, load = by_hand()
    assert tutorial["mean_load"] == pytest.approx(mean, rel=1e-5)
    assert tutorial["peak_inlet"] == pytest.approx(highest, rel=1e-5)
    final = tutorial["run"].final_state
    assert final.inlet_pressure == pytest.approx(inlet, rel=1e-5)
    assert final.load_pressure == pytest.approx(load, rel=1e-5)


def test_the_mean_follows_from_the_flow_through_the_load(tutorial: dict[str, Any]) -> None:
    """What goes to the load in the mean leaves it through the orifice: the circuit's own outputs and books agree."""
    run, values = tutorial["run"], tutorial["values"]
    given, taken = run.state.books.given_out, run.state.books.taken_in
    assert taken[-1] == pytest.approx(values.pump_flow * run.end, rel=1e-12)
    held = [tutorial["stored"](s, values).volume for s in (run.case.state, run.final_state)]
    assert taken[-1] - given[-1] == pytest.approx(held[1] - held[0], abs=1e-7 * taken[-1])
