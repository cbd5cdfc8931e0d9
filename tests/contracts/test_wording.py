"""Every sentence of `tests/words` is used by a test, every one that a test names is there, and none is there twice."""

import re
from pathlib import Path

from tests.words import TABLES

TESTS = Path(__file__).parents[1]


def test_every_sentence_is_used_and_there():
    texts = (path.read_text("utf-8") for path in TESTS.rglob("test_*.py"))
    used = {found for text in texts for found in re.findall(r"\bwording\.(\w+\.\w+)", text)}
    there = {f"{verb}.{key}" for verb, table in TABLES.items() for key in table}
    assert sorted(used - there) == []
    assert sorted(there - used) == []


def test_no_sentence_is_there_twice():
    sentences = [sentence for table in TABLES.values() for sentence in table.values()]
    assert sorted({each for each in sentences if sentences.count(each) > 1}) == []
