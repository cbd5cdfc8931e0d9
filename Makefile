# On a machine with python3 (3.11 or newer), pip and make: `make run` simulates the prototype, `make test` runs the tests.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin

.PHONY: run setup test test-slow lint bench docs dist clean

run: setup
	$(BIN)/vvdp run prototype

setup: $(VENV)/ready

# Debian's python3 without python3-venv cannot put pip into an environment: then the outer pip does it.
$(VENV)/ready: requirements.lock pyproject.toml
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' \
		|| { echo "vvdp needs Python 3.11 or newer; $(PYTHON) is $$($(PYTHON) --version 2>&1)"; exit 1; }
	@rm -rf $(VENV)
	@$(PYTHON) -m venv $(VENV) >/dev/null 2>&1 \
		|| { rm -rf $(VENV); $(PYTHON) -m venv --without-pip $(VENV) && $(PYTHON) -m pip --python $(BIN)/python install --quiet pip; } \
		|| { rm -rf $(VENV); echo "no virtual environment can be made: install pip and venv (Debian: apt-get install python3-pip python3-venv)"; exit 1; }
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --require-hashes -r requirements.lock
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --no-deps --no-build-isolation -e .
	@touch $@

test: setup
	$(BIN)/python -m pytest -n 2 -m "not slow"

test-slow: setup
	$(BIN)/python -m pytest -m slow

lint: setup
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy

bench: setup
	$(BIN)/python -m benchmarks.run

# The site goes into the package, where `vvdp docs` looks for it; a broken link or a page without a place fails.
docs: setup
	NO_MKDOCS_2_WARNING=1 $(BIN)/python -m mkdocs build

# What is published: the wheel and the source archive hold the site.
dist: docs
	$(BIN)/python -m hatchling build

clean:
	rm -rf src/vvdp/site dist $(VENV) .pytest_cache .mypy_cache .ruff_cache .hypothesis
