# Verbs: demo, test, test-all, format, benchmark, docs, urdf, clean. Each sets up what it needs in .venv.
PYTHON ?= $(shell for p in python3 python3.13 python3.12 python3.11 python3.14; do \
  $$p -c 'import sys; sys.exit(sys.version_info < (3, 11))' 2>/dev/null && echo $$p && break; done)
BIN := .venv/bin
export PIP_DISABLE_PIP_VERSION_CHECK := 1

.PHONY: demo test test-all tests all-tests lint types format benchmark docs urdf clean
.DEFAULT_GOAL := demo

demo: .venv/.base  ## simulate both gaits of the paper for 30 s; numbers, plot and film in out/
	$(BIN)/python examples/first_roll.py

test: .venv/.dev lint  ## format, lint, types, and every test but the slow ones
	@$(MAKE) --no-print-directory -j 2 types tests

test-all: .venv/.dev lint  ## also the slow studies
	@$(MAKE) --no-print-directory -j 2 types all-tests

lint: .venv/.dev
	$(BIN)/ruff format --check .
	$(BIN)/ruff check .

types: .venv/.dev
	$(BIN)/mypy

tests: .venv/.dev
	$(BIN)/python -m pytest -n 2 --dist loadfile

all-tests: .venv/.dev
	$(BIN)/python -m pytest -n 2 --dist loadfile -m ''

format: .venv/.dev
	$(BIN)/ruff format .
	$(BIN)/ruff check --fix .

benchmark: .venv/.bench  ## speed and peers; writes benchmarks/results and docs/benchmarks.md
	$(BIN)/python -m benchmarks.full_model
	$(BIN)/python -m benchmarks.engine
	$(BIN)/python -m benchmarks.grounds
	$(BIN)/python -m benchmarks.peers
	$(BIN)/python -m benchmarks.simulators
	$(BIN)/python -m benchmarks.machines
	$(BIN)/python -m benchmarks.report

docs: .venv/.docs  ## the documentation site in out/site, from docs/ and the docstrings; no network
	$(BIN)/python -m sphinx -n -W --keep-going -q -E -b html -d out/site-doctrees docs out/site
	@echo "wrote out/site/index.html"

urdf: .venv/.base  ## write urdf/*.urdf anew from the parameters
	$(BIN)/python -c 'from rrrobot.robot.urdf import main; main()'

clean:
	rm -rf .venv .venv-peers out build dist .pytest_cache .mypy_cache .ruff_cache

.venv/bin/pip:
	@test -n "$(PYTHON)" || { echo "rrrobot needs Python 3.11 or newer; set PYTHON=/path/to/python"; exit 1; }
	@$(PYTHON) -m venv .venv || { rm -rf .venv; $(PYTHON) -m pip install -q --target .tools virtualenv \
	  && PYTHONPATH=.tools $(PYTHON) -m virtualenv -q .venv && rm -rf .tools; } \
	  || { rm -rf .venv .tools; echo "$(PYTHON) can make no virtual environment: install its venv module"; exit 1; }

.venv/.base: .venv/bin/pip pyproject.toml
	@echo "once: downloads Pinocchio, Matplotlib, Numba and others into .venv, which takes minutes"
	$(BIN)/pip install -q --no-compile -e .
	@touch $@

.venv/.dev: .venv/bin/pip pyproject.toml
	$(BIN)/pip install -q --no-compile -e '.[robots,dev]'
	@touch $@ .venv/.base .venv/.docs

.venv/.docs: .venv/bin/pip pyproject.toml
	$(BIN)/pip install -q --no-compile -e '.[docs]'
	@touch $@ .venv/.base

.venv/.bench: .venv/.dev
	$(BIN)/pip install -q --no-compile -e '.[robots,dev,bench]'
	@touch $@
