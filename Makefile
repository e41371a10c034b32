# Two commands do everything: `make plan` and `make test`. Both make .venv first if need be.
# `make experiments` runs what takes longer: the published experiments, and comparisons of processor times.
PYTHON ?= python3
ROAD ?= commute
ARGS ?= --corridor road
VENV := .venv
BIN := $(VENV)/bin

PYTEST := $(BIN)/python -m pytest

# compiled modules are kept also where the environment asks Python not to: tests start many processes
unexport PYTHONDONTWRITEBYTECODE
# matrices here are bands or small: several threads take turns waiting for each other, which triples the time of two test processes
export OPENBLAS_NUM_THREADS ?= 1
export OMP_NUM_THREADS ?= 1
export MKL_NUM_THREADS ?= 1

.PHONY: plan test check experiments first-hour bench docs gallery clean

plan: $(VENV)/.installed
	$(BIN)/energy-mgr plan $(ROAD) $(ARGS) --out out/plan

test: check
	$(PYTEST) --numprocesses 2 --dist loadfile -m "not slow and not timing"

check: $(VENV)/.installed-test
	$(BIN)/ruff format --check .
	$(BIN)/ruff check .
	$(BIN)/basedpyright
	$(BIN)/lint-imports
	$(BIN)/mkdocs build --strict --quiet

# comparisons of processor times come last, one at a time
experiments: $(VENV)/.installed-test
	$(PYTEST) --numprocesses 2 --dist loadfile -m "slow and not timing"
	$(PYTEST) -m timing

# every command and Python block of the documents, and the wheel, in fresh environments of its own
first-hour:
	$(PYTHON) -m tests.first_hour

bench: $(VENV)/.installed-bench
	$(BIN)/python -m benchmarks

docs: $(VENV)/.installed-test
	$(BIN)/mkdocs serve

gallery: $(VENV)/.installed
	$(BIN)/python -m roads.gallery.archetypes

clean:
	rm -rf $(VENV) out site

$(BIN)/python:
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || { \
		echo "energy-mgr needs Python 3.11 or newer, '$(PYTHON)' is: $$($(PYTHON) --version 2>&1)."; \
		echo "Install a newer one (python.org, or your system's package manager) and say: make $(MAKECMDGOALS) PYTHON=python3.12"; exit 1; }
	$(PYTHON) -m venv $(VENV)

# an install that is cut short leaves no mark, so that the next call takes it up again
$(VENV)/.installed: pyproject.toml | $(BIN)/python
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --editable .
	@$(BIN)/python -m compileall -q roads powertrain energy_mgr
	@touch $@

$(VENV)/.installed-test: pyproject.toml | $(BIN)/python
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --editable '.[test]'
	@$(BIN)/python -m compileall -q roads powertrain energy_mgr
	@touch $@ $(VENV)/.installed

$(VENV)/.installed-bench: pyproject.toml | $(BIN)/python
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --editable '.[bench]'
	@touch $@ $(VENV)/.installed
