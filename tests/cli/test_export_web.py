"""`vvdp export web`."""

import json

from vvdp.web.page import MOST_BYTES


def test_writes_one_file_and_says_what_is_in_it(vvdp, here, keys_as_described):
    done = vvdp("export", "web", "hydrostatic-transmission", "--until", "0.2 s", "--out", "page.html", "--json")
    assert done.code == 0, done.err
    found = json.loads(done.out)
    keys_as_described("export web", found)
    assert found["bytes"] == (here / "page.html").stat().st_size < MOST_BYTES
    assert found["level"] == "exact"
    assert [path.name for path in here.iterdir() if path.suffix == ".html"] == ["page.html"]
    again = vvdp("export", "web", "hydrostatic-transmission", "--out", "page.html")
    assert again.code == 2
    assert "page.html" in again.err and "--force" in again.err
