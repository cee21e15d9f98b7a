# The verbs of this project. Everything runs in .venv, made from the hashed lock by the first verb that needs it.

SHELL := /bin/bash
.DEFAULT_GOAL := help
PYTHON ?= $(shell command -v python3.11 || command -v python3)
VENV := .venv
BIN := $(VENV)/bin
READY := $(VENV)/.ready

.PHONY: help demo test test-slow test-faults check bench serve openapi lock clean

help:  ## list the verbs
	@grep -hE '^[a-z-]+:.*##' $(MAKEFILE_LIST) | sed -E 's/:[^#]*## /\t/' | expand -t 12

$(READY): requirements/lock.txt pyproject.toml
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info[:2] != (3, 11))' || \
	  { echo "gear-rattle needs Python 3.11, and $(PYTHON) is another: set PYTHON=/path/to/python3.11"; exit 1; }
	$(PYTHON) -m venv --clear $(VENV)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --require-hashes --only-binary=:all: -r requirements/lock.txt
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --no-deps --no-build-isolation --editable .
	@touch $(READY)

demo: $(READY)  ## Fig. 7 of the paper over REST: demo/basin.zarr, demo/basin.png, a table of solutions
	@$(BIN)/python demo/run.py

test: $(READY)  ## run the tests (minutes)
	$(BIN)/python -m pytest

test-slow: $(READY)  ## run the slow tests as well
	$(BIN)/python -m pytest -m 'not faults'

test-faults: $(READY)  ## kill and fill things from outside (minutes; as root also full and read-only disks)
	$(BIN)/python -m pytest -m faults

check: $(READY)  ## formatting, lint, types, import layers, spelling
	$(BIN)/ruff format --check .
	$(BIN)/ruff check .
	$(BIN)/mypy
	$(BIN)/lint-imports
	$(BIN)/codespell rattle_kernels worker service tests docs demo README.md CHANGELOG.md

bench: $(READY)  ## time kernels, assembly and panels; docs/performance.json and the table in docs/performance.md
	$(BIN)/python -m pytest benchmarks -m '' --benchmark-columns=min,median,ops --benchmark-sort=name --benchmark-json=.benchmarks/run.json
	$(BIN)/python -m benchmarks.table .benchmarks/run.json

serve: $(READY)  ## the service with two local workers on 127.0.0.1:8000
	$(BIN)/rattle serve

openapi: $(READY)  ## write docs/openapi.yaml from the code
	$(BIN)/python -m service.openapi > docs/openapi.yaml

lock: $(READY)  ## pin every dependency anew (needs uv)
	uv pip compile --quiet --generate-hashes --no-emit-index-url --no-emit-find-links --no-header --no-annotate --no-emit-package gear-rattle \
	  --python-version 3.11 --extra dev --output-file requirements/lock.txt pyproject.toml

clean:  ## remove the environment, caches and the demo's results
	rm -rf $(VENV) .mypy_cache .pytest_cache .ruff_cache .hypothesis demo/basin.zarr demo/basin.png demo/data
