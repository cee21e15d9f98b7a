"""What the wheel and the sdist hold: all of the packages, and nothing else."""

import subprocess
import tarfile
import zipfile

import pytest
from packaging.metadata import Metadata

import rattle
from tests.distribution.conftest import ROOT, build

PACKAGES = (
    "rattle_chart",
    "rattle_machine",
    "rattle_notebook",
    "rattle_paper",
    "rattle_proof",
    "rattle",
    "rattle_kernels",
    "service",
    "worker",
)
BESIDE = {
    "CHANGELOG.md",
    "CITATION.cff",
    "LICENSE",
    "PKG-INFO",
    "README.md",
    "hatch_build.py",
    "pyproject.toml",
    ".gitignore",
}


def source_files():
    """Files of the packages that git keeps or would keep."""
    command = ["git", "ls-files", "--cached", "--others", "--exclude-standard", *PACKAGES]
    listed = subprocess.run(command, cwd=ROOT, check=True, capture_output=True, text=True).stdout.splitlines()
    return {name for name in listed if (ROOT / name).exists()}


def contents_of(wheel):
    """Bytes of each file."""
    with zipfile.ZipFile(wheel) as archive:
        return {name: archive.read(name) for name in archive.namelist()}


@pytest.fixture(scope="module")
def unpacked(distribution, tmp_path_factory):
    """Folder of the sdist's files."""
    folder = tmp_path_factory.mktemp("sdist")
    with tarfile.open(distribution.sdist) as archive:
        # Python before 3.11.4 has no filters; from 3.14 on this one is the default.
        archive.extraction_filter = getattr(tarfile, "data_filter", None)
        archive.extractall(folder)
    (inside,) = folder.iterdir()
    return inside


def test_the_wheel_holds_the_packages_and_nothing_else(distribution):
    names = set(contents_of(distribution.wheel))
    described = {name for name in names if ".dist-info/" in name}
    assert names - described == source_files()
    assert {name.partition("/")[2] for name in described} == {
        "METADATA", "RECORD", "WHEEL", "entry_points.txt", "licenses/LICENSE",
    }  # fmt: skip


def test_the_wheel_holds_what_is_no_python(distribution):
    names = set(contents_of(distribution.wheel))
    assert names >= {f"{package}/py.typed" for package in PACKAGES}
    assert names >= {"service/explorer/index.html", "service/explorer/js/main.js", "service/api_page/index.html"}
    assert any(name.startswith("service/records/migrations/versions/") for name in names)


def test_the_sdist_holds_what_building_needs_and_nothing_else(unpacked):
    names = {str(path.relative_to(unpacked)) for path in unpacked.rglob("*") if path.is_file()}
    assert names == source_files() | BESIDE


def test_the_sdist_builds_the_same_wheel(distribution, unpacked, tmp_path):
    assert contents_of(build(unpacked, tmp_path).wheel) == contents_of(distribution.wheel)


def test_the_metadata_is_valid_and_says_who_and_what(distribution):
    contents = contents_of(distribution.wheel)
    (written,) = (text for name, text in contents.items() if name.endswith(".dist-info/METADATA"))
    metadata = Metadata.from_email(written, validate=True)
    assert str(metadata.version) == rattle.__version__
    assert metadata.author == "The gear-rattle developers" and metadata.license_expression == "BSD-3-Clause"
    assert metadata.project_urls == {"Paper": "https://doi.org/10.1142/S021812740902283X"}
    assert metadata.description_content_type == "text/markdown" and "# gear-rattle" in metadata.description
