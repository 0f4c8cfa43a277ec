# `make demo` and `make test` need nothing but Python 3.11 or newer: the rest is installed
# into .venv. On Windows use the pip lines of the README.

PYTHON ?= python3
BIN := .venv/bin
SUPPLY := .venv/tools/bin
COMPILE := $(SUPPLY)/uv pip compile --quiet --upgrade --universal --generate-hashes --python-version 3.11 \
  --custom-compile-command 'make pins'
# Every command that the tests start would compile all modules and grammars anew.
unexport PYTHONDONTWRITEBYTECODE

.PHONY: demo test test-slow sweep fuzz bench speed lint format pins audit sbom wheel viewer editor vscode vsix clean

# The demo computes its poses with the toolbox, and does without it where it cannot be installed.
.venv/demo: pyproject.toml
	$(PYTHON) -m venv .venv
	$(BIN)/python -m pip install --quiet --editable '.[plot,virtual,rws,toolbox]' || \
	  $(BIN)/python -m pip install --quiet --editable '.[plot,virtual,rws]'
	touch $@

# What tests and lint need, by its hashes.
.venv/test: pyproject.toml .ci/install .ci/backends.txt .ci/pins.txt
	.ci/install $(PYTHON)
	touch $@ .venv/demo

.venv/supply: pyproject.toml
	$(PYTHON) -m venv .venv/tools
	$(SUPPLY)/python -m pip install --quiet cyclonedx-bom pip-audit uv
	touch $@

.venv/fuzz: .venv/test
	$(BIN)/python -m pip install --quiet --editable '.[fuzz]'
	touch $@

.venv/bench: pyproject.toml
	$(PYTHON) -m venv .venv
	$(BIN)/python -m pip install --quiet --editable '.[bench]'
	touch $@ .venv/demo

demo: .venv/demo
	$(BIN)/robot-assistant demo

# Many tests wait for a server, a line or a clock: more workers than cores.
test: .venv/test
	$(BIN)/python -m pytest --numprocesses 4 --dist worksteal

# Also the property tests of `make test`, with cases that are drawn anew.
test-slow: .venv/test
	$(BIN)/python -m pytest --numprocesses 2 --dist worksteal --hypothesis-profile=fresh \
	  -m "slow or hypothesis" --override-ini faulthandler_timeout=3600

# Cuts off every command that writes, at one of EVERY calls that change files, and tells what is lost.
EVERY := 2
sweep: .venv/test
	$(BIN)/python -m tests.sweep --every $(EVERY) $(COMMANDS)

# Goes on from what earlier runs left in .fuzz: SECONDS of all targets, or INPUTS of each of them.
SECONDS ?= 300
fuzz: .venv/fuzz
	$(BIN)/python -m tests.fuzz $(TARGETS) $(if $(INPUTS),--inputs=$(INPUTS),--seconds=$(SECONDS))

bench: .venv/bench
	$(BIN)/python -m benchmarks

# Fails if a task takes more than twice the CPU time that it takes today, beside a plain Python loop.
speed: .venv/test
	$(BIN)/python -m benchmarks.ratios

lint: .venv/test
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy

format: .venv/test
	$(BIN)/ruff check --fix .
	$(BIN)/ruff format .

# What tests and lint are installed by, for all systems and Python 3.11 and later.
pins: .venv/supply
	$(COMPILE) --group backends --output-file .ci/backends.txt
	$(COMPILE) pyproject.toml --extra lint --output-file .ci/pins.txt

# Known vulnerabilities of the pinned versions; needs the network, and fails without it.
audit: .venv/supply
	$(SUPPLY)/pip-audit --strict --disable-pip --require-hashes --requirement .ci/pins.txt || \
	  { echo 'Vulnerable, or not audited: see above. Of what was not audited nothing is known.' >&2; false; }

# What somebody gets who installs all extras today, as CycloneDX, checked against its schema.
sbom: .venv/supply
	rm -rf .venv/user && $(PYTHON) -m venv .venv/user
	.venv/user/bin/python -m pip install --quiet '.[all]'
	.venv/user/bin/python -m pip uninstall --quiet --yes pip setuptools
	mkdir -p dist
	$(SUPPLY)/cyclonedx-py environment --pyproject pyproject.toml --mc-type application \
	  --output-reproducible --output-format JSON --output-file dist/robot-assistant.cdx.json .venv/user

# The same commit gives the same bytes.
wheel: .venv/test
	SOURCE_DATE_EPOCH=$$(git log -1 --format=%ct) $(BIN)/python -m build --no-isolation

# What pages of `view` are drawn by, made anew: needs npm and a network.
viewer:
	cd assistant/view/three && npm install --no-save --prefix ../../../.venv/npm three@0.187.0 esbuild@0.28.2
	cd .venv/npm && node_modules/.bin/esbuild ../../assistant/view/three/entry.js --bundle --minify \
	  --format=iife --global-name=THREE --legal-comments=inline --target=es2020 \
	  --alias:three=./node_modules/three --outfile=../../assistant/view/three/three.js
	cp .venv/npm/node_modules/three/LICENSE assistant/view/three/LICENSE

# The editor of the studio, made anew: needs npm and a network.
CODEMIRROR := state@6.7.6 view@6.43.15 commands@6.11.1 language@6.13.1 search@6.7.2 \
  autocomplete@6.20.4 lint@6.9.8
editor:
	mkdir -p .venv/npm && cd .venv/npm && \
	  npm install --no-save --prefix . $(addprefix @codemirror/,$(CODEMIRROR)) esbuild@0.28.2
	cd .venv/npm && NODE_PATH=$(CURDIR)/.venv/npm/node_modules node_modules/.bin/esbuild \
	  ../../assistant/studio/codemirror/entry.js --bundle --minify --format=esm \
	  --legal-comments=inline --target=es2020 --outfile=../../assistant/studio/codemirror/codemirror.js

# What VS Code runs of its extension, made anew: needs npm and a network.
CLIENT := vscode-languageclient@9.0.1 vscode-textmate@9.3.2 vscode-oniguruma@2.0.1 esbuild@0.28.2
CLIENT_PARTS := vscode-languageclient vscode-languageserver-protocol vscode-languageserver-types \
  vscode-jsonrpc minimatch balanced-match brace-expansion semver
vscode:
	mkdir -p .venv/npm && cd .venv/npm && npm install --no-save --prefix . $(CLIENT)
	cd .venv/npm && NODE_PATH=$(CURDIR)/.venv/npm/node_modules node_modules/.bin/esbuild \
	  ../../assistant/editing/vscode/client/entry.js --bundle --minify --platform=node --format=cjs \
	  --external:vscode --legal-comments=inline --target=node18 \
	  --outfile=../../assistant/editing/vscode/client/client.js
	cd .venv/npm/node_modules && for part in $(CLIENT_PARTS); do echo "$$part"; echo; \
	  cat $$part/[Ll][Ii][Cc]*; echo; done > ../../../assistant/editing/vscode/client/LICENSE

# The extension for VS Code, of our own tables.
vsix: .venv/test
	mkdir -p dist && $(BIN)/robot-assistant lsp --extension dist/robot-assistant.vsix

clean:
	rm -rf .venv build dist out
