"""`vvdp docs`: where the pages are, what opens them, what is said where there are none."""

import webbrowser

import pytest

from vvdp.cli import docs
from vvdp.cli.main import main


@pytest.fixture
def built(tmp_path, monkeypatch):
    (tmp_path / "index.html").write_text("<h1>vvdp</h1>")
    monkeypatch.setattr(docs, "SITE", tmp_path)
    return tmp_path / "index.html"


@pytest.fixture
def opened(monkeypatch):
    pages = []
    monkeypatch.setattr(webbrowser, "open", lambda uri: bool(pages.append(uri)) or True)
    return pages


def code(*arguments):
    with pytest.raises(SystemExit) as ended:
        main(["docs", *arguments])
    return ended.value.code


def test_the_first_page_is_opened(built, opened, capsys):
    assert not code()
    assert opened == [built.as_uri()] and not capsys.readouterr().out


def test_the_path_is_printed_and_nothing_opened(built, opened, capsys):
    assert not code("--path")
    assert capsys.readouterr().out == f"{built}\n" and not opened


def test_without_a_browser_the_path_is_printed(built, monkeypatch, capsys):
    monkeypatch.setattr(webbrowser, "open", lambda uri: False)
    assert not code()
    assert capsys.readouterr().out == f"{built}\n"


def test_without_pages_it_says_how_to_build_them(tmp_path, monkeypatch, opened, capsys):
    monkeypatch.setattr(docs, "SITE", tmp_path / "site")
    assert code() == 1
    assert "make docs" in capsys.readouterr().err and not opened
