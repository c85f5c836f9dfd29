"""The documentation and CITATION.cff fit one another, the code and the measured tables."""

import re
import tomllib
from pathlib import Path
from pydoc import locate

import pytest
import yaml

ROOT = Path(__file__).resolve().parents[1]
DOCS = ROOT / "docs"
README = (ROOT / "README.md").read_text()
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
PAGES = sorted([ROOT / "README.md", ROOT / "CONTRIBUTING.md", *DOCS.glob("*.md")])


def test_the_readme_links_to_what_is_there():
    links = re.findall(r"\]\(([^)#:]+)(?:#[^)]*)?\)", README)
    assert [link for link in links if not (ROOT / link).exists()] == []


def test_the_readme_quotes_the_measured_gains():
    pages = ("captures_unknown", "captures_384", "captures_known", "claims", "how_many", "videos")
    text = "".join((DOCS / "results" / f"{name}.md").read_text() for name in pages)
    measured = set(re.findall(r"\+(\d\.\d+) ±|(?<=\| )(\d\.\d+)(?= \|)", text))
    measured = {gain for either in measured for gain in either}
    quoted = re.findall(r"(?<![-.\d])(\d\.\d+) dB", README)
    assert len(quoted) >= 3
    assert [gain for gain in quoted if gain not in measured] == []


@pytest.mark.parametrize("folder", ["results", "notebook"])
def test_an_index_names_every_page_of_its_folder(folder):
    linked = re.findall(r"\]\(([\w-]+\.md)\)", (DOCS / folder / "index.md").read_text())
    assert set(linked) == {p.name for p in (DOCS / folder).glob("*.md")} - {"index.md"}


def test_every_page_that_the_command_writes_is_there():
    pages = yaml.safe_load((DOCS / "results" / "pages.yaml").read_text())["pages"]
    assert [name for name in pages if not (DOCS / "results" / f"{name}.md").is_file()] == []


@pytest.mark.parametrize("page", PAGES, ids=lambda path: path.name)
def test_names_of_the_library_in_prose_exist(page):
    prose = re.sub(r"```.*?```", "", page.read_text(), flags=re.S)
    names = re.findall(r"`(fsel(?:\.(?!json)\w+)+)[`(]", prose)
    assert [name for name in names if locate(name) is None] == []


def test_the_software_and_the_paper_are_cited_and_the_changelog_knows_the_version():
    cited = yaml.safe_load((ROOT / "CITATION.cff").read_text())
    assert (cited["title"], cited["license"]) == (PROJECT["name"], PROJECT["license"])
    assert cited["preferred-citation"]["title"].startswith("Less Is More: Genetic Frame Selection")
    assert f"\n## {PROJECT['version']}\n" in (ROOT / "CHANGELOG.md").read_text()
