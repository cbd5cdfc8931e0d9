"""The one refusal where a library of an extra is missing."""

import sys

import pytest

from vvdp.base.errors import ConfigError
from vvdp.base.extras import MissingExtraError, require


def test_what_is_installed_is_let_pass_without_importing_it():
    """`wave` stands for a library that nothing has imported."""
    sys.modules.pop("wave", None)
    require("wave", "opt", "a picture")
    assert "wave" not in sys.modules


def test_what_is_missing_is_named_with_its_extra_and_its_purpose():
    with pytest.raises(MissingExtraError) as caught:
        require("no_such_library", "opt", "an optimum")
    assert str(caught.value) == "an optimum needs no_such_library, which is not installed: pip install 'vvdp[opt]'"
    assert not isinstance(caught.value, ConfigError)  # nothing that was typed is wrong
