"""The prototype's valve, its shape and its solids, made once; a command line."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import pytest

from vvdp.cli.main import main
from vvdp.geometry.mesh import Mesh
from vvdp.geometry.shape import ValveShape, valve_shape
from vvdp.geometry.solids import sleeve, spool
from vvdp.systems.system import load_system
from vvdp.valve.rotary import RotaryValve


@pytest.fixture(scope="session")
def built_valve() -> RotaryValve:
    return load_system("prototype", ()).tables["valve"]


@pytest.fixture(scope="session")
def built_shape(built_valve) -> ValveShape:
    return valve_shape(built_valve)[0]


@pytest.fixture(scope="session")
def larger_valve(built_valve) -> RotaryValve:
    """A quarter larger in all lengths."""
    lengths = ("spool_radius", "helix_length", "land_length", "inlet_radius", "outlet_radius", "radial_clearance")
    longer = {name: 1.25 * getattr(built_valve, name) for name in lengths}
    wider = {name: 1.25**2 * getattr(built_valve, name) for name in ("nozzle_area", "outlet_area")}
    return replace(built_valve, **longer, **wider)


@pytest.fixture(scope="session")
def spool_mesh(built_shape, built_valve) -> Mesh:
    return spool(built_shape, built_valve, 25.0)


@pytest.fixture(scope="session")
def sleeve_mesh(built_shape, built_valve) -> Mesh:
    return sleeve(built_shape, built_valve, 25.0)


class Said(NamedTuple):
    code: int
    out: str
    err: str


@pytest.fixture
def command(capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[..., Said]:
    """Runs `vvdp geometry` in an empty folder."""
    monkeypatch.chdir(tmp_path)

    def call(*arguments: str) -> Said:
        capsys.readouterr()
        with pytest.raises(SystemExit) as ended:
            main(["geometry", *arguments])
        code = ended.value.code
        return Said(code if isinstance(code, int) else 0, *capsys.readouterr())

    return call
