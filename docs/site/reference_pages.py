"""The generated pages of the reference: verbs from their help, packages from their docstrings, literature."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import typer.main

import vvdp
from vvdp.cli.main import app
from vvdp.report.references import bibliography

ROOT = Path(__file__).parents[2] / "src" / "vvdp"
WIDTH = 88
"""Characters of a line of help."""
PACKAGES = sorted(path.parent.name for path in ROOT.glob("*/__init__.py") if path.parent.name != "cli")


def pages() -> dict[str, str]:
    """The text of each page by its path."""
    return {
        "reference/verbs.md": verbs_page(),
        "reference/literature.md": literature_page(),
        "reference/python.md": python_page(),
        **{f"reference/python/{name}.md": package_page(name) for name in PACKAGES},
    }


def python_page() -> str:
    """What `import vvdp` offers, and the packages below it."""
    public = {name: getattr(vvdp, name) for name in vvdp.__all__}
    offered = [f"## vvdp.{name}\n\n::: {each.__module__}.{each.__qualname__}\n" for name, each in public.items()]
    packages = [f"- [`vvdp.{n}`](python/{n}.md): {_summary(ROOT / n / '__init__.py')}" for n in PACKAGES]
    head = "# Python\n\n::: vvdp\n    options:\n      members: false\n"
    return "\n".join([head, *offered, "## Packages\n", *packages, ""])


def package_nav() -> list[str | dict[str, str]]:
    """The pages of the Python reference in their order."""
    return ["reference/python.md", *({f"vvdp.{name}": f"reference/python/{name}.md"} for name in PACKAGES)]


def verbs_page() -> str:
    """Every verb with its help as the terminal shows it."""
    sections = [f"## {name} {{ #{name.replace(' ', '-')} }}\n\n```text\n{text}\n```\n" for name, text in _help()]
    return "# Verbs and options\n\nWhat `--help` says of each verb.\n\n" + "\n".join(sections)


def _help() -> Iterator[tuple[str, str]]:
    """The name of each verb, those of groups in three words, and its help."""

    def walk(command: Any, parent: Any, name: str) -> Iterator[tuple[str, str]]:
        settings = {"terminal_width": WIDTH, "max_content_width": WIDTH, **command.context_settings}
        context = command.context_class(command, parent=parent, info_name=name, **settings)
        yield context.command_path, command.get_help(context).strip()
        for word, inner in getattr(command, "commands", {}).items():
            if not inner.hidden:
                yield from walk(inner, context, word)

    return walk(typer.main.get_command(app), None, "vvdp")


def package_page(name: str) -> str:
    """The modules of a package, each with what it offers."""
    modules = sorted(path.stem for path in (ROOT / name).glob("*.py") if not path.stem.startswith("_"))
    head = f"# vvdp.{name}\n\n{_summary(ROOT / name / '__init__.py')}\n\n"
    return head + "\n".join(f"## {module}\n\n::: vvdp.{name}.{module}\n" for module in modules)


def _summary(path: Path) -> str:
    """The first line of a module's docstring."""
    text = path.read_text("utf-8").lstrip()
    return text[3:].partition("\n")[0].rstrip('"').strip() if text.startswith('"""') else ""


def literature_page() -> str:
    """The bibliography by key."""
    entries = sorted(bibliography().items())
    rows = [f"| `{key}` | {r.authors} ({r.year}): *{r.title}*. {r.place} |" for key, r in entries]
    return "\n".join(
        ["# Literature", "", "What `Source` and `[key]` stand for.", "", "| key | |", "| --- | --- |", *rows, ""]
    )
