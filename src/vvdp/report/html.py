"""Pieces of HTML. Whatever comes from a user's file passes through `text`."""

import re
from collections.abc import Iterable, Sequence
from html import escape


def text(value: object) -> str:
    """`value` with the characters that HTML reserves made harmless."""
    return escape(str(value), quote=True)


def table(head: Sequence[str], rows: Iterable[str], numeric: Sequence[int] = (), kind: str = "") -> str:
    """A table with `rows` made by `row` or `group`; the columns `numeric` are aligned right."""
    cells = "".join(f"<th{' class=n' if i in numeric else ''}>{name}</th>" for i, name in enumerate(head))
    opening = f'<table class="{kind}">' if kind else "<table>"
    return f"{opening}\n<thead><tr>{cells}</tr></thead>\n<tbody>\n" + "\n".join(rows) + "\n</tbody>\n</table>"


def row(cells: Sequence[str], classes: Sequence[str] = (), kind: str = "") -> str:
    """A row of ready HTML cells, each with a class where `classes` names one."""
    named = [*classes, *[""] * (len(cells) - len(classes))]
    inner = "".join(
        f'<td class="{c}">{cell}</td>' if c else f"<td>{cell}</td>" for cell, c in zip(cells, named, strict=True)
    )
    return f'<tr class="{kind}">{inner}</tr>' if kind else f"<tr>{inner}</tr>"


def group(name: str, columns: int) -> str:
    """A row that names the rows below it."""
    return f'<tr class="group"><th colspan="{columns}">{name}</th></tr>'


def inline_svg(svg: str, name: str) -> str:
    """An SVG file as an element of a page, its identifiers made its own by `name`; `--natural` is its own width."""
    body = svg[svg.index("<svg") :]
    known = set(re.findall(r'\bid="([^"]+)"', body))
    body = re.sub(r'\bid="([^"]+)"', rf'id="{name}-\1"', body)
    body = re.sub(r"url\(#([^)]+)\)", rf"url(#{name}-\1)", body)
    body = re.sub(r'href="#([^"]+)"', lambda m: f'href="#{name}-{m[1]}"' if m[1] in known else m[0], body)
    body = re.sub(r'viewBox="\S+ \S+ ([\d.]+)', r'style="--natural: \1px" \g<0>', body, count=1)
    return re.sub(r"<metadata>.*?</metadata>\s*", "", body, flags=re.DOTALL)


def share_letters(page: str) -> str:
    """A page whose figures take the shapes of letters from the first figure that has them, with less text for each."""
    shorter = re.sub(
        r'<use xlink:href="#[\w-]*?(DejaVuSans[\w-]*)"(?: transform="translate\(([-\d.]+) 0\)")?',
        lambda use: f'<use href="#{use[1]}"' + (f' x="{use[2]}"' if use[2] else ""),
        page,
    )
    known = set[str]()

    def once(shape: re.Match[str]) -> str:
        is_first = shape[1] not in known
        known.add(shape[1])
        return f'<path id="{shape[1]}"{shape[2]}' if is_first else ""

    shared = re.sub(r'<path id="[\w-]*?(DejaVuSans[\w-]*)"([^>]*>\s*)', once, shorter)
    return re.sub(r"<defs>\s*</defs>\s*", "", shared)


def figure(svg: str, name: str, number: int, caption: str) -> str:
    """A numbered figure with its caption, already HTML."""
    words = f"<figcaption><b>Figure {number}.</b> {caption}</figcaption>"
    return f'<figure id="figure-{name}">\n{inline_svg(svg, name)}{words}\n</figure>'
