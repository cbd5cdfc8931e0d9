"""A page for each component and program of the library, from its code: `vvdp.systems.library_pages`."""

import re
from collections.abc import Iterator, Sequence

from docstrings import markdown

from vvdp.components.library import COMPONENTS
from vvdp.programs.library import PROGRAMS
from vvdp.report.symbol_set import entry, generic, picture
from vvdp.systems.library_pages import Described, Equation, LibraryPage, library_page

DOCS_PAGE = re.compile(r"\bdocs/([\w/-]+)\.md")
LIBRARIES = {"components": COMPONENTS, "programs": PROGRAMS}
TITLES = {"components": "Components one by one", "programs": "Programs one by one"}
LISTS = {"components.md": "components", "programs.md": "programs"}
"""Written pages whose tables name the types."""


def pages() -> dict[str, str]:
    """The text of each page by its path."""
    found = {}
    for folder, library in LIBRARIES.items():
        found[f"reference/{folder}/index.md"] = _index(folder)
        found |= {f"reference/{folder}/{kind}.md": page_text(library_page(kind)) for kind in library}
    return found


def linked(text: str, page: str) -> str:
    """The text of a written page with a link from each row of a type to its own page."""
    folder = LISTS.get(page)
    if folder is None:
        return text
    return re.sub(
        r"^\| `([\w-]+)` \|",
        lambda row: f"| [`{row[1]}`](reference/{folder}/{row[1]}.md) |" if row[1] in LIBRARIES[folder] else row[0],
        text,
        flags=re.MULTILINE,
    )


def _index(folder: str) -> str:
    rows = [
        f"| [`{kind}`]({kind}.md) | {_first_sentence(library_page(kind).description)} |" for kind in LIBRARIES[folder]
    ]
    return "\n".join([f"# {TITLES[folder]}", "", "| type | what it models |", "|---|---|", *rows, ""])


def _first_sentence(text: str) -> str:
    return re.split(r"[.;:](?:\s|$)", text, maxsplit=1)[0].replace("\n", " ").replace("|", r"\|")


def page_text(page: LibraryPage) -> str:
    """The page of one type as Markdown."""
    sections = [f"# {page.type}", _symbol(page.type), markdown(page.description)]
    if page.ports:
        sections.append("Ports: " + ", ".join(f"`{port.name}` {port.meaning}".strip() for port in page.ports) + ".")
    sections += [_table(title, rows) for title, rows in _tables(page) if rows]
    if page.rules:
        sections.append("## Accepted values\n\n" + "\n".join(f"- {rule}" for rule in page.rules))
    if page.warnings:
        sections.append("## Warnings of a run\n\n" + "\n".join(f"- {each}" for each in page.warnings))
    if page.example:
        command = f"`vvdp new mine --from {page.type}` writes this file as `mine.toml`; `vvdp run mine.toml` runs it."
        sections.append(f"## Example\n\n{command}\n\n```toml\n{page.example}```")
    sections.append("## Equations\n\n" + "\n\n".join(_equations(page.equations)))
    return "\n\n".join(section for section in sections if section) + "\n"


def _symbol(kind: str) -> str:
    """The symbol in a circuit diagram; a program has none."""
    if kind not in COMPONENTS:
        return ""
    name = COMPONENTS[kind].symbol
    found = entry(name)
    drawn = picture(found.draw() if found else generic(name, {}))
    return f'<div class="symbol" title="symbol in circuit diagrams">{drawn}</div>'


def _tables(page: LibraryPage) -> Iterator[tuple[str, Sequence[Described]]]:
    yield ("Inputs" if page.ports or not page.inputs else "What it reads"), page.inputs
    yield "Parameters", page.values
    yield ("Outputs" if page.type in COMPONENTS else "Commands"), page.outputs


def _table(title: str, rows: Sequence[Described]) -> str:
    has_values = any(row.example or row.usual for row in rows) and title not in ("Outputs", "Commands")
    heads = ["name", "meaning", "unit", *(["example", "default"] if has_values else [])]
    lines = ["| " + " | ".join(heads) + " |", "|---" * len(heads) + "|"]
    for row in rows:
        cells = [f"`{row.name}`", row.meaning, row.unit]
        cells += [f"`{row.example}`" if row.example else "", row.usual] if has_values else []
        lines.append("| " + " | ".join(cell.replace("|", r"\|") for cell in cells) + " |")
    return f"## {title}\n\n" + "\n".join(lines)


def _equations(equations: Sequence[Equation]) -> Iterator[str]:
    yield "The code that runs; further steps follow in the order in which they are called."
    for each in equations:
        source = DOCS_PAGE.sub(r"[\g<0>](../../\1.md)", each.source)
        head = f"**`{each.name}`**: {each.description}" + (f" *Source:* {source}" if source else "")
        yield f"{head}\n\n```python\n{each.text.rstrip()}\n```"
