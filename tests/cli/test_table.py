"""The layout of tables: at any width every number is whole, every line fits, and no cell is lost."""

import random
import re

import pytest

from vvdp.cli.table import Column, table_blocks

WORDS = ("relief", "valve", "of", "the", "inlet", "rail", "bulk_modulus", "see", "4.2", "section")


def column(head, *cells, numeric=False):
    return Column(head, cells, numeric)


def lines(blocks):
    return [line for block in blocks for line in (*block.head, block.rule, *block.body)]


def random_columns(seed):
    draw = random.Random(seed)
    rows = draw.randint(1, 12)
    columns = [column("key", *(f"row_{k}" for k in range(rows)))]
    for k in range(draw.randint(1, 14)):
        numbers = [f"{draw.uniform(-1, 1) * 10 ** draw.randint(-3, 5):.{draw.randint(0, 5)}f}" for _ in range(rows)]
        texts = [" ".join(draw.choices(WORDS, k=draw.randint(0, 9))) for _ in range(rows)]
        numeric = k % 3 > 0
        head = f"load pressure {k} [bar]" if numeric else f"note {k}"
        columns.append(column(head, *(numbers if numeric else texts), numeric=numeric))
    return columns


@pytest.mark.parametrize("width", [60, 80, 120])
@pytest.mark.parametrize("seed", range(20))
@pytest.mark.parametrize("transpose", [False, True])
def test_numbers_are_whole_and_lines_fit(seed, width, transpose):
    columns = random_columns(seed)
    blocks = table_blocks(columns, width, transpose=transpose)
    assert max(map(len, lines(blocks))) <= width
    shown = {word for line in lines(blocks) for word in line.split()}
    assert {word for each in columns for cell in each.cells for word in cell.split()} <= shown


def test_decimal_points_stand_under_each_other():
    (block,) = table_blocks([column("load", "17.13", "0.0271", "3374", "\u221211.66", "71.4*", "–", numeric=True)], 80)
    points = {line.index(".") for line in block.body if "." in line}
    assert len(points) == 1
    (point,) = points
    assert block.body[2].rstrip().endswith("4")
    assert len(block.body[2].rstrip()) == point
    assert block.body[5].index("–") == point - 1


def test_what_fits_is_one_table():
    blocks = table_blocks([column("a", "x"), column("b", "1", numeric=True)], 80)
    assert lines(blocks) == ["  a   b", " ───────", "  x   1"]


def test_text_is_wrapped_at_words_before_a_table_is_split():
    note = "usual for mineral oil of the grade that the data sheet names"
    (block,) = table_blocks([column("key", "thermal_expansion"), column("value", "7e-4"), column("note", note)], 60)
    start = block.head[0].index("note")
    assert " ".join(line[start:] for line in block.body) == note
    assert "thermal_expansion" in block.body[0]


def test_each_part_of_a_split_table_begins_with_its_keys():
    keys = [column("flow [lpm]", "40", "20", numeric=True), column("oil [°C]", "40", "50", numeric=True)]
    others = [column(f"loss {k} [W]", "1234.5", "67.89", numeric=True) for k in range(12)]
    blocks = table_blocks([*keys, *others], 60, keys=2)
    assert len(blocks) > 1
    for block in blocks:
        assert [line.split()[:2] for line in block.body] == [["40", "40"], ["20", "50"]]
    for block in table_blocks([*keys, *others], 60, keys=2, ends=1):
        assert [line.split()[-1] for line in block.body] == ["1234.5", "67.89"]
        assert "11" in " ".join(block.head).split()
    (turned,) = table_blocks([*keys, *others], 60, keys=2, transpose=True)
    assert turned.head[0].split() == ["flow", "[lpm]", "40", "20"]
    assert turned.body[0].split() == ["oil", "[°C]", "40", "50"]
    assert turned.body[12].split() == ["loss", "11", "[W]", "1234.5", "67.89"]


def test_a_word_longer_than_the_screen_is_broken_and_a_number_beside_it_is_not():
    (block,) = table_blocks([column("file", "x" * 100), column("size", "123456.789", numeric=True)], 60)
    assert "".join(re.findall("x+", " ".join(block.body))) == "x" * 100
    assert "123456.789" in block.body[0]


def test_a_single_column_is_wrapped_and_not_lost():
    (block,) = table_blocks(
        [column("what it is", "a sentence that is longer than sixty characters and has no neighbour")], 60
    )
    assert len(block.body) == 2
