"""Pages beside those that are written: verbs, the library, Python, literature, notebooks, circuits that run."""

import sys
from pathlib import Path

from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import File, Files
from mkdocs.structure.pages import Page

HERE = Path(__file__).parent
sys.path[:0] = [str(HERE), str(HERE.parents[1] / "src")]

import live_pages  # noqa: E402
import notebooks  # noqa: E402
import reference_pages  # noqa: E402
import type_pages  # noqa: E402


def on_config(config: MkDocsConfig) -> MkDocsConfig:
    """Puts the pages of the packages below the reference."""
    reference = next(entry["Reference"] for entry in config.nav if "Reference" in entry)
    reference[-1] = {"Python": reference_pages.package_nav()}
    return config


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Adds the generated pages."""
    pages = {
        **reference_pages.pages(),
        **notebooks.pages(),
        **type_pages.pages(),
        **dict(live_pages.pages()),
    }
    for path, text in pages.items():
        files.append(File.generated(config, path, content=text))
    return files


def on_page_markdown(markdown: str, page: Page, config: MkDocsConfig, files: Files) -> str:
    """Puts circuits that run into the pages that show them; links the library's tables to the page of each type."""
    return live_pages.with_frames(type_pages.linked(markdown, page.file.src_uri), page.url)


def on_post_build(config: MkDocsConfig) -> None:
    """Leaves out what only the makers of the theme need."""
    for path in Path(config.site_dir).rglob("*.map"):
        path.unlink()
