# On a machine with python3 (3.11 or newer), pip and make: `make run` simulates the prototype with what vvdp itself needs;
# `make test` adds all extras and the tools of development to the same environment, and runs the tests.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
PIP := $(BIN)/python -m pip install --quiet --disable-pip-version-check
LOCK := uv pip compile pyproject.toml --quiet --universal --python-version 3.11 --group build \
	--generate-hashes --no-annotate --no-header

# Tests that need few minutes, for other versions than those of the locks.
SMOKE := tests/base tests/fluid tests/network tests/numerics tests/results tests/fitting tests/logs/test_readers.py \
	tests/cli/test_run.py tests/cli/test_export.py tests/cli/test_plot.py tests/systems/test_examples.py
LOWEST := .venv-lowest

# Byte code is kept, whatever the environment says: the tests start hundreds of processes.
export PYTHONDONTWRITEBYTECODE :=

.PHONY: run setup test test-thorough test-slow test-lowest lint bench docs dist lock sbom audit clean

run: $(VENV)/core
	$(BIN)/vvdp run prototype

setup: $(VENV)/full

# Debian's python3 without python3-venv cannot put pip into an environment: then the outer pip does it.
$(VENV)/core: requirements-core.lock pyproject.toml
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' \
		|| { echo "vvdp needs Python 3.11 or newer; $(PYTHON) is $$($(PYTHON) --version 2>&1)"; exit 1; }
	@rm -rf $(VENV)
	@$(PYTHON) -m venv $(VENV) >/dev/null 2>&1 \
		|| { rm -rf $(VENV); $(PYTHON) -m venv --without-pip $(VENV) && $(PYTHON) -m pip --python $(BIN)/python install --quiet pip; } \
		|| { rm -rf $(VENV); echo "no virtual environment can be made: install pip and venv (Debian: apt-get install python3-pip python3-venv)"; exit 1; }
	$(PIP) --require-hashes -r requirements-core.lock
	$(PIP) --no-deps --no-build-isolation -e .
	@touch $@

$(VENV)/full: requirements.lock $(VENV)/core
	$(PIP) --require-hashes -r requirements.lock
	@touch $@

# A file's tests share what is expensive, so they stay on one worker; the order is that of tests/conftest.py.
PYTEST := $(BIN)/python -m pytest -n 2 --dist loadfile --no-loadscope-reorder

test: setup
	$(PYTEST) -m "not slow and not thorough"

test-thorough: setup
	$(PYTEST) -m "thorough and not slow"

test-slow: setup
	$(BIN)/python -m pytest -m slow

# The lowest versions that pyproject.toml admits, resolved by uv, with the newest of what these need in turn.
test-lowest:
	uv venv --quiet --clear --python $(PYTHON) $(LOWEST)
	uv pip install --quiet --python $(LOWEST) --resolution lowest-direct -e '.[dev]'
	$(LOWEST)/bin/python -m pytest -m "not slow and not thorough" $(SMOKE)

lint: setup
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy

bench: setup
	$(BIN)/python -m benchmarks.run

# Versions that are in a lock stay; `make lock UPGRADE=--upgrade` takes the newest.
lock:
	$(LOCK) $(UPGRADE) --extra dev -o requirements.lock
	$(LOCK) -c requirements.lock -o requirements-core.lock

# The bill of materials, from the locks and the installed packages' own words on their licences.
sbom: setup
	$(BIN)/python -m supply.bill

# Known weaknesses of the pinned versions, asked of a public data base: by hand, for CI needs no network.
audit:
	uv tool run pip-audit --strict --disable-pip --require-hashes -r requirements.lock

# Material 9 needs MkDocs 1, and warns of MkDocs 2, which it will never support; the lock pins both. The plan: move to
# Zensical, by the makers of Material, which reads mkdocs.yml, once it runs hooks and searches without a network.
# The site goes into the package, where `vvdp docs` looks for it; a broken link or a page without a place fails.
docs: setup
	NO_MKDOCS_2_WARNING=1 $(BIN)/python -m mkdocs build

# What is published: the wheel and the source archive hold the site.
dist: docs
	$(BIN)/python -m hatchling build

clean:
	rm -rf src/vvdp/site dist $(VENV) $(LOWEST) .pytest_cache .mypy_cache .ruff_cache .hypothesis
