# `make demo` and `make test` need nothing but Python 3.11 or newer: the rest is installed
# into .venv. On Windows use the pip lines of the README.

PYTHON ?= python3
BIN := .venv/bin
# Every command that the tests start would compile all modules and grammars anew.
unexport PYTHONDONTWRITEBYTECODE

.PHONY: demo test test-slow fuzz bench lint format clean

.venv/demo: pyproject.toml
	$(PYTHON) -m venv .venv
	$(BIN)/python -m pip install --quiet --editable '.[plot,virtual,rws]'
	touch $@

.venv/test: pyproject.toml
	$(PYTHON) -m venv .venv
	$(BIN)/python -m pip install --quiet --editable '.[test]'
	touch $@ .venv/demo

.venv/lint: pyproject.toml
	$(PYTHON) -m venv .venv
	$(BIN)/python -m pip install --quiet --editable '.[lint]'
	touch $@ .venv/test .venv/demo

.venv/fuzz: pyproject.toml
	$(PYTHON) -m venv .venv
	$(BIN)/python -m pip install --quiet --editable '.[fuzz]'
	touch $@ .venv/test .venv/demo

.venv/bench: pyproject.toml
	$(PYTHON) -m venv .venv
	$(BIN)/python -m pip install --quiet --editable '.[bench]'
	touch $@ .venv/demo

demo: .venv/demo
	$(BIN)/robot-assistant demo

# Many tests wait for a server, a line or a clock: more workers than cores.
test: .venv/test
	$(BIN)/python -m pytest --numprocesses 3 --dist worksteal

# Also the property tests of `make test`, with cases that are drawn anew.
test-slow: .venv/test
	$(BIN)/python -m pytest --numprocesses 2 --dist worksteal --hypothesis-profile=fresh \
	  -m "slow or hypothesis"

# Goes on from what earlier runs left in .fuzz: SECONDS of all targets, or INPUTS of each of them.
SECONDS ?= 300
fuzz: .venv/fuzz
	$(BIN)/python -m tests.fuzz $(TARGETS) $(if $(INPUTS),--inputs=$(INPUTS),--seconds=$(SECONDS))

bench: .venv/bench
	$(BIN)/python -m benchmarks

lint: .venv/lint
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy

format: .venv/lint
	$(BIN)/ruff check --fix .
	$(BIN)/ruff format .

clean:
	rm -rf .venv build dist out
