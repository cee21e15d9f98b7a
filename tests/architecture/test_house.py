"""What strangers rely on: the README runs, names are documented, the lock names no host."""

import inspect
import json
import re
import subprocess
import tomllib
from pathlib import Path

import pytest

import rattle_kernels
from worker.jobs.basin_job import BasinJob

ROOT = Path(__file__).parents[2]
README = (ROOT / "README.md").read_text()


def blocks(language):
    return re.findall(rf"```{language}\n(.*?)```", README, re.DOTALL)


@pytest.mark.parametrize("code", blocks("python"), ids=lambda code: code.splitlines()[0][:40])
def test_the_readmes_python_runs(code, service, tmp_path, monkeypatch, capsys):
    """As printed, but for the address of a service that runs here, and fewer cells."""
    monkeypatch.chdir(tmp_path)
    code = code.replace("http://127.0.0.1:8000", service.url).replace('"cells": 500', '"cells": 30')
    exec(compile(code, "README.md", "exec"), {})
    assert capsys.readouterr().out.strip()


def test_the_readmes_request_is_one_that_the_service_takes():
    requests = [re.search(r"-d '(\{.*?\})'", block, re.DOTALL) for block in blocks("sh")]
    bodies = [json.loads(found.group(1)) for found in requests if found]
    assert bodies
    for body in bodies:
        BasinJob.from_request(body)


def test_every_verb_that_the_readme_names_is_there():
    makefile = (ROOT / "Makefile").read_text()
    named = set(re.findall(r"`?make ([a-z-]+)", README))
    assert named >= {"demo", "test", "check", "serve", "bench", "docs", "help"}
    for verb in named:
        assert re.search(rf"^{verb}:", makefile, re.MULTILINE), verb


def test_pictures_and_files_that_the_readme_links_are_there():
    for target in re.findall(r"\]\(([^)#]+)\)", README):
        assert target.startswith("https://") or (ROOT / target).exists(), target


@pytest.mark.parametrize("name", [name for name in rattle_kernels.__all__ if callable(getattr(rattle_kernels, name))])
def test_public_names_are_documented(name):
    documented = inspect.getdoc(getattr(rattle_kernels, name))
    assert documented and len(documented) > 20


def packages_of(name):
    lock = (ROOT / "requirements" / name).read_text()
    assert "://" not in lock and "--index-url" not in lock
    packages = re.findall(r"^[a-z0-9].*?(?=^[a-z0-9]|\Z)", lock, re.MULTILINE | re.DOTALL)
    assert all("==" in package and "--hash=sha256:" in package for package in packages)
    return packages


def without_markers(packages):
    """A marker names whom a package is for: with other extras these are others."""
    return {re.sub(r" (;.*|\\)$", "", package, count=1, flags=re.MULTILINE) for package in packages}


def test_locks_name_no_host_and_pin_every_package_by_hash_and_the_image_has_some_of_the_same():
    everything, of_image = packages_of("lock.txt"), packages_of("image.txt")
    assert len(everything) > len(of_image) > 60
    assert without_markers(of_image) <= without_markers(everything)
    assert not any(package.startswith(("pytest", "mypy", "moto", "ruff")) for package in of_image)


def test_every_python_named_in_the_metadata_is_looked_for_and_none_is_refused():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    assert project["requires-python"] == ">=3.11"
    looked_for = subprocess.run([ROOT / ".ci" / "pythons"], capture_output=True, text=True, check=True, timeout=60)
    found = dict(re.findall(r"^(3\.\d+) (.*)$", looked_for.stdout, re.MULTILINE))
    named = [each for each in project["classifiers"] if each.startswith("Programming Language")]
    assert [f"Programming Language :: Python :: {version}" for version in found] == named
    for version, path in found.items():
        if path:
            told = subprocess.run([path, "--version"], capture_output=True, text=True, check=True, timeout=60).stdout
            assert told.startswith(f"Python {version}.")
