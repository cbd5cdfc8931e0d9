"""The words of the language, as `vvdp list --language` prints them."""

import json

from typer.testing import CliRunner

from vvdp.cli.main import app
from vvdp.generator.words import word_names


def test_the_words_are_listed():
    done = CliRunner().invoke(app, ["list", "--language", "--json"])
    assert done.exit_code == 0
    assert json.loads(done.stdout) == {"functions": word_names()}
    assert {"abs", "range", "math.erfc", "np.expm1", "np.zeros"} <= set(word_names())
    printed = CliRunner().invoke(app, ["list", "--language"]).stdout.split()
    assert set(word_names()) <= set(printed)
