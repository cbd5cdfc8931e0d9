"""What the server of processes has loaded before it forks one: a call then begins at once, with the loop at hand.

Batches are small here, so that a second of work is kept in ten pieces.
"""

import contextlib
import os
from collections.abc import Sequence
from pathlib import Path

import vvdp.rigs.maps as maps
import vvdp.studies.run as studies
from vvdp.cli.main import main
from vvdp.simulation.loops import compiled_loop
from vvdp.studies.work import Batching

compiled_loop(lambda _: None)


def call(words: Sequence[str], place: Path) -> None:
    """Carries out a command in a folder, what it says in the file `said` beside; ends as the command does."""
    maps.BATCHING = Batching(least=2, seconds=0.0)
    studies.Batching = lambda group: Batching(least=2, seconds=0.0, group=group)
    os.chdir(place)
    with (place.parent / "said").open("a") as said, contextlib.redirect_stdout(said), contextlib.redirect_stderr(said):
        main(list(words))
