# The verbs of this project. Everything runs in .venv, made from the hashed lock by the first verb that needs it,
# with PYTHON or else the oldest Python here that will do.

SHELL := /bin/bash
.DEFAULT_GOAL := help
ifndef PYTHON
PYTHON := $(or $(shell .ci/pythons --oldest | awk 'NF == 2 { print $$2 }'),python3)
endif
VERSION := $(shell $(PYTHON) -c 'import sys; print("%d.%d" % sys.version_info[:2])' 2>/dev/null)
VENV := .venv
BIN := $(VENV)/bin
# Of one version: asked for another, the environment is made anew.
READY := $(VENV)/.ready-$(VERSION)
# The environment belongs to this folder alone, so root may install into it.
PIP_INSTALL := PIP_ROOT_USER_ACTION=ignore $(BIN)/python -m pip install --quiet --disable-pip-version-check

# Debian's packages, for root; others are told what to ask for.
install = { test "$$(id -u)" = 0 && apt-get update -qq && apt-get install --yes -qq --no-install-recommends $(1) >/dev/null; } || \
  { echo "install these packages first: $(1)"; exit 1; }

# Tests of one file share what they have built.
ON_TWO_CORES := --numprocesses 2 --dist loadfile

.PHONY: help demo test test-pythons test-processors test-golden test-slow test-planted test-faults test-load test-backends test-containers test-hosts test-browser test-all screenshots check check-explorer bench compare docs dist serve openapi settings lock clean

help:  ## list the verbs
	@grep -hE '^[a-z-]+:.*##' $(MAKEFILE_LIST) | sed -E 's/:[^#]*## /\t/' | expand -t 12

$(READY): requirements/lock.txt pyproject.toml
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' 2>/dev/null || \
	  { echo "gear-rattle needs Python 3.11 or newer, and $(PYTHON) is none: set PYTHON=/path/to/python3.13, say"; exit 1; }
	@echo "setting up $(VENV), the first time only: some 1.4 GB, a minute or two"
	@$(PYTHON) -m venv --clear $(VENV)
	@$(PIP_INSTALL) --require-hashes --only-binary=:all: -r requirements/lock.txt
	@$(PIP_INSTALL) --no-deps --no-build-isolation --editable .
	@touch $(READY)

demo: $(READY)  ## Fig. 7 of the paper over REST: demo/basin.zarr, demo/basin.png, a table of solutions
	@$(BIN)/python demo/run.py

test: $(READY)  ## run the tests (minutes); PYTHON=python3.13 on that one
	$(BIN)/python -m pytest $(ON_TWO_CORES) $(TESTS)

test-pythons:  ## run the tests on every Python from 3.11 to 3.14 that is here
	@.ci/test-pythons

# On a cold cache most of their time is spent on compiling the kernels for each target.
test-processors: $(READY)  ## the same bytes for every processor that this one can stand in for (minutes)
	$(BIN)/python -m pytest -m '' tests/rattle_kernels/numerics/test_fused_multiply_add.py tests/worker/basins/test_same_bytes.py

# Some of them are among the slow ones, too; before a change is merged they run by themselves.
test-golden: $(READY)  ## results to the byte against golden stores, and proofs (minutes)
	$(BIN)/python -m pytest -m '' $(ON_TWO_CORES) tests/golden
	$(BIN)/python -m pytest -m 'proof and not slow and not planted' $(ON_TWO_CORES)

# In lanes a wrong index corrupts other lanes without a sign, unless it is checked.
BOUNDS_CHECKED := $(addprefix tests/rattle_kernels/,numerics impact_map lanes cell_mapping attractors/test_classify.py) \
  $(addprefix tests/rattle_proof/enclosures/,test_interval.py test_enclosed_functions.py)

test-slow: $(READY)  ## the slow tests, and small tests of the kernels with checked array bounds
	$(BIN)/python -m pytest $(ON_TWO_CORES) -m 'slow and not browser and not faults and not containers and not hosts and not distribution and not planted'
	NUMBA_BOUNDSCHECK=1 $(BIN)/python -m pytest -m 'not slow' $(BOUNDS_CHECKED)

# Each fault compiles its proof anew.
test-planted: $(READY)  ## plant faults in the proofs, one after another: their tests must catch each (minutes)
	$(BIN)/python -m pytest -m planted $(ON_TWO_CORES) --dist load

test-faults: $(READY)  ## kill and fill things from outside (minutes; as root also full and read-only disks)
	$(BIN)/python -m pytest -m faults

test-load: $(READY)  ## 100 requests a second for a minute while tiles compute; on a quiet machine
	RATTLE_LOAD_SECONDS=60 $(BIN)/python -m pytest -m faults -s tests/faults/test_load.py

test-backends: $(READY)  ## the tests of service and worker once more, on PostgreSQL and S3
	@command -v initdb >/dev/null || ls /usr/lib/postgresql/*/bin/initdb >/dev/null 2>&1 || $(call install,postgresql)
	RATTLE_TEST_BACKENDS=1 $(BIN)/python -m pytest tests/service tests/worker $(ON_TWO_CORES)

test-containers: $(READY)  ## build the image and run it, without an engine; as root
	@command -v buildah podman runc debootstrap >/dev/null || $(call install,buildah podman runc debootstrap)
	$(BIN)/python -m pytest tests/containers -m containers --timeout 5400

test-hosts: $(READY)  ## compose file, Kubernetes manifests and Slurm's scripts on hosts of a network; hostile clients
	@command -v initdb >/dev/null || ls /usr/lib/postgresql/*/bin/initdb >/dev/null 2>&1 || $(call install,postgresql)
	@command -v nginx >/dev/null || ls /usr/sbin/nginx >/dev/null 2>&1 || $(call install,nginx-light)
	@command -v curl >/dev/null || $(call install,curl)
	@ls /usr/sbin/slurmctld /usr/sbin/slurmd /usr/bin/sbatch >/dev/null 2>&1 || $(call install,slurmctld slurmd slurm-client)
	$(BIN)/python -m pytest tests/hosts -m hosts --timeout 1200

# A process of their own, so that kernels are compiled before the first service starts.
test-browser: $(READY) node_modules  ## the explorer in the system's Chromium
	@command -v chromium >/dev/null || $(call install,chromium fonts-dejavu-core)
	$(BIN)/python -m pytest tests/browser -m browser --numprocesses 1 --timeout 240

test-all:  ## every suite, also after one that fails; build/suites.json has when each last passed (hours; as root)
	@$(PYTHON) .ci/test-all $(SUITES)

screenshots: $(READY)  ## pictures of every state of the explorer: screenshots, and the README's in docs/pictures
	@command -v chromium >/dev/null || $(call install,chromium fonts-dejavu-core)
	$(BIN)/python -m tests.browser.thumbnails
	$(BIN)/python -m tests.browser.screenshots

# ESLint, TypeScript's type check and axe, for the explorer's scripts and its tests.
node_modules: package-lock.json
	@command -v npm >/dev/null || $(call install,nodejs npm)
	npm ci --no-audit --no-fund --silent
	@touch node_modules

check-explorer: node_modules  ## unit tests, lint and types of the explorer's scripts
	npm run --silent lint
	npm run --silent types
	npm run --silent test

check: $(READY) check-explorer docs  ## formatting, lint, types, import layers, declared dependencies, spelling, and the documentation site
	$(BIN)/ruff format --check .
	$(BIN)/ruff check .
	$(BIN)/mypy
	$(BIN)/lint-imports
	$(BIN)/deptry .
	$(BIN)/codespell rattle_kernels worker service rattle rattle_chart rattle_machine rattle_notebook rattle_paper rattle_proof tests docs demo README.md CHANGELOG.md CONTRIBUTING.md SECURITY.md CITATION.cff

bench: $(READY)  ## time kernels, assembly and panels; docs/performance.json and the table in docs/performance.md
	$(BIN)/python -m pytest benchmarks -m '' --benchmark-columns=min,median,ops --benchmark-sort=name --benchmark-json=.benchmarks/run.json
	$(BIN)/python -m benchmarks.table .benchmarks/run.json

compare: $(READY)  ## this project and others on the same work: build/suite.json, build/suite.png (docs/benchmarks.md)
	$(BIN)/python -m benchmarks.suite

# Warnings are errors: a broken link, a missing docstring, a reference that leads nowhere. Made anew each time: kept parts
# would hide what a change elsewhere has broken.
docs: $(READY)  ## the documentation site: build/site/index.html
	@rm -rf build/site
	$(BIN)/python -m sphinx --quiet --fail-on-warning --fresh-env --conf-dir docs/site --doctree-dir build/doctrees . build/site

dist: $(READY)  ## wheel and sdist in dist, tried in empty environments on the oldest and newest Python here (minutes)
	@rm -rf dist
	$(BIN)/python -m hatchling build
	RATTLE_DIST=dist $(BIN)/python -m pytest -m '' tests/distribution

serve: $(READY)  ## the service with two local workers on 127.0.0.1:8000
	$(BIN)/rattle serve

openapi: $(READY)  ## write docs/openapi.yaml from the code
	$(BIN)/python -m service.openapi > docs/openapi.yaml

settings: $(READY)  ## write the table of docs/operations/settings.md from the code
	@sed -i '/^| variable/,$$d' docs/operations/settings.md
	$(BIN)/python -m service.settings >> docs/operations/settings.md

LOCK := uv pip compile --quiet --universal --generate-hashes --no-emit-index-url --no-emit-find-links --no-header --no-annotate \
  --no-emit-package gear-rattle --python-version 3.11

lock: $(READY)  ## pin every dependency anew, and of those the ones that the container image has (needs uv)
	$(LOCK) --extra dev --output-file requirements/lock.txt pyproject.toml
	$(LOCK) --extra image --constraint requirements/lock.txt --output-file requirements/image.txt pyproject.toml

clean:  ## remove the environment, caches, builds and the demo's results
	rm -rf build dist .venv .venv-* .mypy_cache .pytest_cache .ruff_cache .hypothesis demo/basin.zarr demo/basin.png demo/data demo/service.log
