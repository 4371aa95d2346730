# Set-up, run and test. Everything is installed into .venv, from versions and hashes that are locked.
SHELL := /bin/sh
PYTHON ?= $(shell for p in python3 python3.14 python3.13 python3.12 python3.11; do \
	command -v $$p >/dev/null 2>&1 && $$p -c 'import sys; sys.exit(sys.version_info < (3, 11))' 2>/dev/null && echo $$p && break; done)
BIN := .venv/bin

SECONDS := 300
MINUTES := 5
SEED := 0

.PHONY: run test check format install bench fuzz soak lock samples pictures pages

run: install
	@$(BIN)/weft

# Tests run on all cores, each process with a display of its own and one thread for BLAS; what compares timings is alone.
ALONE := tests/benchmarks

test: install check
	OPENBLAS_NUM_THREADS=1 $(BIN)/python -m pytest --numprocesses logical --dist worksteal --benchmark-disable --ignore=$(ALONE)
	$(BIN)/python -m pytest $(ALONE)

check: .venv/installed
	$(BIN)/ruff format --check .
	$(BIN)/ruff check .
	$(BIN)/mypy --num-workers auto
	$(BIN)/lint-imports

format: .venv/installed
	$(BIN)/ruff format .
	$(BIN)/ruff check --fix .

install: .venv/installed

.venv/installed: pyproject.toml requirements.lock system-packages.sh
	@test -n "$(PYTHON)" || { echo "weft: needs Python 3.11 or newer" >&2; exit 1; }
	@PYTHON=$(PYTHON) sh system-packages.sh
	@test -x $(BIN)/python && $(BIN)/python -m pip --version >/dev/null 2>&1 || $(PYTHON) -m venv --clear .venv
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --no-compile --require-hashes -r requirements.lock
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --no-deps --no-build-isolation -e .
	@$(BIN)/python -m compileall -qq -j 0 .venv/lib app core || true
	@touch $@

bench: install
	$(BIN)/weft bench

# Malformed files for every reader, then kills in the middle of writing; each follows from its number, from SEED on.
fuzz: install
	$(BIN)/python -m tests.fuzz --seconds $(SECONDS) --seed $(SEED)
	$(BIN)/python -m tests.fuzz.kills --seed $(SEED)
	$(BIN)/python -m tests.fuzz.batch_kills --seed $(SEED)

# The real window under a hand without a plan.
soak: install
	$(BIN)/python -m tests.fuzz.soak --minutes $(MINUTES) --seed $(SEED)

samples: install
	$(BIN)/python assets/make_samples.py

pictures: install
	PYTHONPATH=. $(BIN)/python docs/make_pictures.py
	PYTHONPATH=. $(BIN)/python docs/make_guide.py

pages: install
	PYTHONPATH=. $(BIN)/python docs/make_pages.py

lock: .venv/installed
	$(BIN)/uv pip compile --quiet --universal --fork-strategy fewest --python-version 3.11 --group dev pyproject.toml \
		--generate-hashes --no-header --no-annotate --upgrade -o requirements.lock
