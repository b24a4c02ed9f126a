# Everything runs in .venv, made from the lock files; `make help` lists the targets.

PYTHON ?= python3
JOBS ?= 2
PYTEST_ARGS ?=
PARTS ?=
OUT ?= paper-output

VENV := .venv
BIN := $(VENV)/bin
PIP := $(BIN)/python -m pip --disable-pip-version-check
UV := $(BIN)/uv
# Each process begins with half of the tests in their order, so that what the tests of a file
# share is made once; who is done takes over half of what the other still has.
PYTEST := $(BIN)/python -m pytest -n $(JOBS) --dist worksteal
LOCK := $(UV) pip compile --quiet --universal --python-version 3.11 \
	--no-emit-index-url --no-emit-find-links --custom-compile-command "make lock"

# One stamp file for each step of the set-up, so that a step is redone only when what it
# depends on has changed.
VENV_MADE := $(VENV)/.made
LOCK_INSTALLED := $(VENV)/.lock-installed
SETUP := $(VENV)/.package-installed
DOCS_INSTALLED := $(VENV)/.docs-installed
BENCH_INSTALLED := $(VENV)/.bench-installed

# pyHarm wants other versions than slipfold, so it has an environment of its own.
PYHARM := $(VENV)/pyharm

# Debian keeps ensurepip apart from python3; root may be spared a second command.
INSTALL_VENV = { \
	[ "$$(id -u)" = 0 ] && command -v apt-get >/dev/null \
	&& echo "installing python3-venv, which Debian keeps apart from python3" \
	&& apt-get update -qq && apt-get install -y -qq python3-venv; } \
	|| { echo "This Python cannot make virtual environments: install python3-venv first" \
	"(on Debian: sudo apt-get install python3-venv)."; exit 1; }

.DEFAULT_GOAL := help
.DELETE_ON_ERROR:
.PHONY: help setup paper explore test long thrown ways-out portable portable-quick lint types layers check bench docs lock clean

help: ## list the targets
	@awk -F ':.*## ' '/^[a-z-]+:.*## / {printf "  make %-14s %s\n", $$1, $$2}' $(MAKEFILE_LIST)

setup: $(SETUP) ## make .venv and install the package in it

paper: $(SETUP) ## reproduce the source paper's figures into paper-output (OUT=DIR for another folder)
	$(BIN)/slipfold paper --out $(OUT)

explore: $(SETUP) ## open the explorer in the browser, for this machine alone
	$(BIN)/slipfold explore

test: $(SETUP) ## run the tests and the examples in the docstrings
	$(PYTEST) $(PYTEST_ARGS)

long: $(SETUP) ## run the tests that take minutes
	$(PYTEST) -m long $(PYTEST_ARGS)

thrown: $(SETUP) ## simulate stick and slip with a hundred thousand random parameters
	$(PYTEST) -m long tests/stick_slip/test_random_parameters.py $(PYTEST_ARGS)

ways-out: $(SETUP) ## take every way out of the explorer's page with every model
	$(PYTEST) -m "long or not long" tests/explorer/browser/test_models.py $(PYTEST_ARGS)

portable: $(SETUP) ## run the numerics' tests as on other processors
	$(call SAME_POINTS)
	for kernel in $(KERNELS); do \
		echo "OPENBLAS_CORETYPE=$$kernel"; \
		OPENBLAS_CORETYPE=$$kernel $(PYTEST) -q $(NUMERICS) || exit 1; \
	done
	for setting in SLIPFOLD_TOLERANCE=3e-14 SLIPFOLD_TOLERANCE=3e-13 SLIPFOLD_LANES=4; do \
		echo "$$setting"; \
		env $$setting $(PYTEST) -q $(NUMERICS) || exit 1; \
	done
	for seed in $$(seq $(SEEDS)); do \
		echo "--perturb-kernels $$seed"; \
		$(PYTEST) -q $(NUMERICS) --perturb-kernels $$seed || exit 1; \
	done

portable-quick: $(SETUP) ## the same in ten minutes: all special points, a part of the tests that the commit chooses
	$(call SAME_POINTS)
	OPENBLAS_CORETYPE=Nehalem $(PYTEST) -q $(NUMERICS) --perturb-kernels $(COMMIT) --one-part-in 3

SAME_POINTS = $(BIN)/python -m pytest -q -n 0 -m portable tests/portable
KERNELS := Nehalem Sandybridge Haswell \
	$(shell grep -qs avx512f /proc/cpuinfo && echo SkylakeX)
NUMERICS := src $(filter-out $(addsuffix /,$(addprefix tests/,bench cli docs explorer helpers \
	interface paper plots results studies)),$(wildcard tests/[a-z]*/))
# Linear algebra answers as another LAPACK might (tests/portable/perturbed_kernels.py).
SEEDS ?= 20
COMMIT = $(shell git rev-parse HEAD 2>/dev/null || echo none)

# Tests and figures start many processes: what they import is compiled once, also where the
# environment has Python keep nothing.
export PYTHONDONTWRITEBYTECODE =

# One thread a process: the matrices are small, and the processes share the cores.
test long thrown ways-out portable portable-quick: export OMP_NUM_THREADS = 1
test long thrown ways-out portable portable-quick: export OPENBLAS_NUM_THREADS = 1

# What runs long runs as it does for users.
long thrown ways-out portable: export SLIPFOLD_OPTIMIZATION = 2

lint: $(SETUP) ## check style and formatting
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .

types: $(SETUP) ## check the types
	$(BIN)/mypy

layers: $(SETUP) ## check which layer imports which
	$(BIN)/lint-imports

check: lint types layers ## lint, types and layers

bench: $(BENCH_INSTALLED) ## compare with other programs in a quarter of an hour (needs gfortran); PARTS="locus size" for some
	$(BIN)/python bench/run.py $(PARTS)

docs: $(DOCS_INSTALLED) ## build the documentation into docs/_build/html
	$(BIN)/sphinx-build -W --keep-going -q -b html docs docs/_build/html

lock: $(VENV_MADE) ## resolve the dependencies anew and write the lock files
	$(PIP) install --quiet "uv>=0.8"
	$(LOCK) --upgrade pyproject.toml --extra explore --extra cluster \
		--group test --group dev -o requirements.lock
	$(LOCK) --upgrade -c requirements.lock --group docs -o requirements-docs.lock
	$(LOCK) --upgrade -c requirements.lock --group bench -o requirements-bench.lock
	$(LOCK) --upgrade --group pyharm -o requirements-pyharm.lock

clean: ## remove everything that the other targets made
	rm -rf $(VENV) $(OUT) build dist docs/_build .pytest_cache .mypy_cache .ruff_cache \
		.hypothesis .import_linter_cache __pycache__
	find bench docs src tests -name __pycache__ -type d -prune -exec rm -rf {} + 2>/dev/null || true

$(VENV_MADE):
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || \
		{ echo "slipfold needs Python 3.11 or later; name one with make PYTHON=python3.12"; exit 1; }
	@$(PYTHON) -c 'import ensurepip, venv' 2>/dev/null || $(INSTALL_VENV)
	$(PYTHON) -m venv $(VENV)
	@touch $@

$(LOCK_INSTALLED): requirements.lock $(VENV_MADE)
	$(PIP) install --quiet -r requirements.lock
	@touch $@

$(SETUP): pyproject.toml $(LOCK_INSTALLED)
	$(PIP) install --quiet --no-deps --no-build-isolation -e .
	@$(BIN)/python -m compileall -q src  # so that no command has to
	@touch $@

$(DOCS_INSTALLED): requirements-docs.lock $(SETUP)
	$(PIP) install --quiet -r requirements-docs.lock
	@touch $@

$(BENCH_INSTALLED): requirements-bench.lock requirements-pyharm.lock $(SETUP)
	@command -v gfortran >/dev/null || \
		{ echo "The benchmarks compare with AUTO-07p, which bifpy compiles while it is" \
		"installed: install gfortran first (on Debian: apt-get install gfortran)."; exit 1; }
	$(PIP) install --quiet -r requirements-bench.lock
	$(PYTHON) -m venv $(PYHARM)
	$(PYHARM)/bin/python -m pip install --quiet --disable-pip-version-check \
		-r requirements-pyharm.lock
	@touch $@
