"""An installed package that offers a circuit and does not load is named in one line."""

from importlib.metadata import EntryPoint

import pytest

from vvdp.base.errors import ConfigError
from vvdp.systems import circuits
from vvdp.systems.system import load_system

BROKEN = {
    "missing": ("no_such_module:network", "ModuleNotFoundError: No module named 'no_such_module'"),
    "raising": ("raising_module:network", "ZeroDivisionError: division by zero"),
    "empty": ("empty_module:network", "AttributeError: module 'empty_module' has no attribute 'network'"),
    "shapeless": ("not a place", "AttributeError"),
}


@pytest.mark.parametrize("name", BROKEN)
def test_a_circuit_that_does_not_load_is_named_with_its_reason(name, tmp_path, monkeypatch):
    (tmp_path / "raising_module.py").write_text("1 / 0\n")
    (tmp_path / "empty_module.py").write_text("")
    monkeypatch.syspath_prepend(tmp_path)
    value, reason = BROKEN[name]
    monkeypatch.setattr(circuits, "_entry_points", lambda: (EntryPoint(name, value, circuits.GROUP),))
    path = tmp_path / "file.toml"
    path.write_text(f'circuit = "{name}"\n[run]\nuntil = "1 s"\n')
    with pytest.raises(
        ConfigError, match=f"'{name}' of an installed package cannot be loaded from '{value}'"
    ) as refused:
        load_system(str(path))
    assert reason in str(refused.value) and f"{path}:1" in str(refused.value)
