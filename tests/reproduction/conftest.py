"""Items worked out in this process."""

from collections.abc import Callable

import pytest

from vvdp.reproduction.expectation import expected_verdicts, verdict_changes, verdicts_of
from vvdp.reproduction.items import chosen_items


@pytest.fixture(scope="session")
def as_expected() -> Callable[[str], list[str]]:
    """Works an item out; a sentence for each of its verdicts that is another than expected."""

    def check(name: str) -> list[str]:
        (item,) = chosen_items([name])
        statements = item.work().statements
        found = verdicts_of((name, statement) for statement in statements)
        assert len(found) == len(statements), "two statements of one name"
        return verdict_changes(found, expected_verdicts(), [name])

    return check
