"""The version is written in pyproject.toml. What repeats it says the same."""

import json
import re
import tomllib

import yaml

import rattle
from service.openapi import document
from tests.distribution.conftest import ROOT

VERSION = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["version"]


def test_the_installed_package_has_the_version():
    assert rattle.__version__ == VERSION


def test_the_api_has_the_version():
    committed = yaml.safe_load((ROOT / "docs" / "openapi.yaml").read_text())
    assert document()["info"]["version"] == committed["info"]["version"] == VERSION


def test_a_store_has_the_version(tmp_path):
    basin = rattle.basin(cells=4, iterations=1, store=tmp_path / "basin.zarr", progress=False)
    assert json.loads(basin.attrs["versions"])["gear-rattle"] == VERSION


def test_the_citation_has_the_version():
    assert yaml.safe_load((ROOT / "CITATION.cff").read_text())["version"] == VERSION


def test_the_changelog_begins_with_the_version():
    first = re.search(r"^## (\S+) \((unreleased|\d{4}-\d\d-\d\d)\)$", (ROOT / "CHANGELOG.md").read_text(), re.MULTILINE)
    assert first and first.group(1) == VERSION
