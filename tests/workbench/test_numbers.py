"""What the page shows as a result is what the offered line prints, for every shipped system."""

import json
import shlex

import pytest

from vvdp.cli.main import main
from vvdp.results.store import finite
from vvdp.simulation.link import quiet
from vvdp.systems.system import shipped_systems
from vvdp.workbench.offer import Asked, Offer
from vvdp.workbench.work import command_line, numbers, whole

MEASURED = ("out", "wall_time_s", "real_time_factor")


@pytest.mark.thorough
@pytest.mark.parametrize("name", sorted(shipped_systems()))
def test_shown_numbers_are_those_of_the_offered_line(name, tmp_path, capsys):
    offer, asked = Offer(tmp_path, name), Asked(name, until="0.05 s")
    shown = json.loads(json.dumps(finite(numbers(whole(offer.system(asked), lambda: False, quiet))["result"])))
    capsys.readouterr()
    line = [*shlex.split(command_line(asked))[1:], "--no-ranges", "--json", "--no-report"]
    with pytest.raises(SystemExit):
        main([*line, "--out", str(tmp_path / "run")])
    printed = json.loads(capsys.readouterr().out)
    assert shown | {key: printed[key] for key in MEASURED if key in printed} == printed
