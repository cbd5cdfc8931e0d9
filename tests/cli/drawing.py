"""How a page draws a file step by step."""

import re


def change(text: str, block: str) -> str:
    """`text` after a block of a page: tables and entries that it has already are replaced, others are added.

    A block of one line is an entry; any other consists of whole tables, or is the whole file.
    """
    if "\n" not in block.strip():
        key = block.partition(" = ")[0]
        changed, count = re.subn(rf"^{key} = .*$", lambda _: block.strip(), text, flags=re.MULTILINE)
        assert count == 1, block
        return changed
    for table in re.split(r"^(?=\[)", block, flags=re.MULTILINE):
        header = table.partition("\n")[0]
        before, found, after = text.partition(f"{header}\n") if header.startswith("[") else ("", "", "")
        if found:
            rest = re.search(r"^\[", after, re.MULTILINE)
            text = f"{before}{table.strip()}\n\n{after[rest.start() :] if rest else ''}"
        else:
            text += f"{table.strip()}\n\n"
    return text
