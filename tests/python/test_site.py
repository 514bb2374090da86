"""The site (tools/docs.sh): it builds without a warning, its search works in a folder without a network, and nothing of a page is cut."""

import os
import subprocess
import sys
from pathlib import Path

import pytest
from chromium_driver import opened
from quoin_tools.front import site
from quoin_tools.show import browser

ROOT = Path(__file__).resolve().parents[2]
WIDTHS = (390, 820, 1400)  # a phone, a tablet, a desk [px]
PAGES = ("README", "docs/scene", "docs/safety", "docs/static_stage", "docs/performance", "docs/python", "docs/c", "docs/reference/joints", "docs/reference/wave", "docs/tutorials/01_first_dam", "examples/guilhofrei/README")
# elements that reach over the edge of the window, unless they or what they are in scroll by themselves
BEYOND = """[...document.querySelectorAll('article *')].filter((e) => {
    if (e.getBoundingClientRect().right <= innerWidth + 1) return false;
    for (let p = e; p; p = p.parentElement) if (['auto', 'scroll'].includes(getComputedStyle(p).overflowX)) return false;
    return true; }).map((e) => e.tagName + ' ' + e.textContent.slice(0, 60))"""


@pytest.fixture(scope="module")
def built(tmp_path_factory):
    """A warning of Sphinx, a link or an anchor that leads nowhere ends this."""
    folder = tmp_path_factory.mktemp("site")
    done = subprocess.run([ROOT / "tools/docs.sh", folder], capture_output=True, text=True, check=False, env=os.environ | {"PIP_NO_INPUT": "1"})
    assert done.returncode == 0, done.stdout + done.stderr
    return folder


needs_chromium = pytest.mark.skipif(not browser.find(), reason="needs Chromium")


# what a first reader asks, and the page that answers: one of the first three that are found
QUESTIONS = [("silt", "docs/reference/silt"), ("bracket", "docs/tutorials/04"), ("fracture_energy", "docs/reference/joints"), ("to_xarray", "docs/python"),
             ("cohesion lost after first crack", "docs/reference/joints"), ("softer joints", "docs/reference/joints"), ("drain level", "docs/reference/drain"), ("uplift follows crack", "docs/reference/uplift"),
             ("stop a run that takes too long", "docs/reference/checkpoint"), ("direction of the earthquake", "docs/reference/pseudo_static"), ("damping dam only", "docs/reference/relaxation"), ("friction after sliding", "docs/reference/joints")]  # fmt: skip


@pytest.mark.long
@needs_chromium
@pytest.mark.parametrize("words, page", QUESTIONS)
def test_search_of_a_folder(built, words, page):
    with opened(built / "README.html") as seen:
        seen.call("Page.navigate", url=(built / "search.html").as_uri() + f"?q={words}")
        seen.value("""new Promise((done) => { const look = () => document.querySelector('#search-results .search-summary')?.textContent.includes('finished') ? done(1) : setTimeout(look, 50); look(); })""")
        links = seen.value("[...document.querySelectorAll('#search-results li a')].map((a) => a.getAttribute('href'))")
        assert any(link.startswith(page) for link in links[:3]), links
        assert [address for address in seen.asked if not address.startswith(("file:", "data:"))] == [] and seen.errors == []


@pytest.mark.long
@needs_chromium
@pytest.mark.parametrize("width", WIDTHS)
def test_nothing_is_cut(built, width):
    for page in PAGES:
        assert (built / f"{page}.html").is_file(), page
        with opened(built / f"{page}.html", width=width, height=900) as seen:
            assert seen.value("document.documentElement.scrollWidth") <= width, page
            assert seen.value(BEYOND) == [], page


@pytest.mark.long
def test_every_document_is_a_page(built):
    documents = [path.relative_to(ROOT).with_suffix(".html") for pattern in ("README.md", "docs/**/*.md", "examples/*/README.md") for path in ROOT.glob(pattern)]
    assert [str(page) for page in documents if not (built / page).is_file()] == []


def test_help_opens_the_site_or_says_how_to_build_it(tmp_path, monkeypatch, capsys):
    there = tmp_path / "site"
    monkeypatch.setattr(site, "folders", lambda: [there])
    addresses: list[str] = []
    monkeypatch.setattr(site.webbrowser, "open", addresses.append)
    with pytest.raises(site.SiteError, match=r"tools/docs\.sh"):
        site.main([])
    there.mkdir()
    (there / "index.html").write_text("", encoding="utf-8")
    assert site.main([]) == 0
    assert addresses == [(there / "index.html").as_uri()] and addresses[0] in capsys.readouterr().out
    done = subprocess.run([sys.executable, ROOT / "tools/quoin.py", "help", "--site", "-h"], capture_output=True, text=True, check=False)
    assert done.returncode == 0 and "browser" in done.stdout
