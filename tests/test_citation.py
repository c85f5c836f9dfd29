"""CITATION.cff and CHANGELOG.md agree with the package."""

import tomllib
from pathlib import Path

import yaml

ROOT = Path(__file__).resolve().parents[1]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]


def test_the_software_and_the_paper_are_cited():
    cited = yaml.safe_load((ROOT / "CITATION.cff").read_text())
    assert (cited["title"], cited["license"]) == (PROJECT["name"], PROJECT["license"])
    assert "version" not in cited  # pyproject.toml alone has it
    paper = cited["preferred-citation"]
    assert paper["title"].startswith("Less Is More: Genetic Frame Selection")
    names = [author["family-names"] for author in paper["authors"]]
    assert names == ["Farchione", "Idoughi", "Jaspe-Villanueva", "Wonka"]


def test_the_changelog_knows_the_version():
    assert f"\n## {PROJECT['version']}\n" in (ROOT / "CHANGELOG.md").read_text()
