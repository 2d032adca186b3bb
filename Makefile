# Usage: make demo | make test. See README.md.
PYTHON ?= python3
BIN := .venv/bin
READY := .venv/.ready

.DEFAULT_GOAL := help
.PHONY: help venv demo test test-slow check format clean

help:  ## list what can be made
	@grep -E '^[a-z-]+:.*##' Makefile | sed -E 's/^([a-z-]+):.*## /  make \1	/'

venv: $(READY)  ## set up .venv with all that demo and test need

$(READY): pyproject.toml constraints.txt
	@command -v $(PYTHON) >/dev/null || { echo "make: no '$(PYTHON)' found: install Python 3.11 or newer, or name one: make venv PYTHON=/path/to/python3" >&2; exit 1; }
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || { echo "make: Python 3.11 or newer is needed, '$(PYTHON)' is $$($(PYTHON) --version 2>&1); name another: make venv PYTHON=/path/to/python3.11" >&2; exit 1; }
	@test -x $(BIN)/python || $(PYTHON) -m venv .venv || { rm -rf .venv; echo "make: '$(PYTHON) -m venv' failed: install Python's venv module (Debian, Ubuntu: apt install python3-venv)" >&2; exit 1; }
	@echo "Setting up .venv: some minutes the first time."
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -c constraints.txt -e '.[dev,film]'
	@touch $@

demo: $(READY)  ## experiment 3 of the thesis: map, find ways round blocks and a short-cut, on film
	$(BIN)/python scripts/experiment.py 3 --seed 0 --film 5,7 --out out/demo

test: $(READY)  ## every test but the slow ones
	$(BIN)/python -m pytest -n 2 -m "not slow" -q -rs

test-slow: $(READY)  ## whole episodes on many seeds
	$(BIN)/python -m pytest -n 2 -m slow -q -rs

check: $(READY)  ## ruff, mypy, import contracts
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports

format: $(READY)  ## let ruff mend what it can
	$(BIN)/ruff check --fix .
	$(BIN)/ruff format .

clean:  ## remove what demo, tests and builds left; .venv stays
	rm -rf out build dist .pytest_cache .mypy_cache .ruff_cache .import_linter_cache .hypothesis
	find cogmap_gym agents scripts tests -name __pycache__ -prune -exec rm -rf {} +
