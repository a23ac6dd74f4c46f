# `make help` lists the targets. Set-up needs Python 3.11 or newer and nothing else.

PYTHON ?= python3
OUT ?= out
VENV := .venv
OLDEST := $(VENV)-oldest
OUTSIDE := tests/planter/test_interface.py tests/planter/cli tests/planter/files
EXTRAS := notebook lab studio parquet cluster compiler step bench sampling control
PYTHONS := 3.11 3.12 3.13 3.14
SCRIPTS := $(if $(filter Windows_NT,$(OS)),Scripts,bin)
BIN := $(VENV)/$(SCRIPTS)
PIP := $(BIN)/python -m pip --disable-pip-version-check install --quiet --constraint constraints.txt
SETUP := pyproject.toml constraints.txt

.DEFAULT_GOAL := help
.DELETE_ON_ERROR:
.PHONY: help optimise test test-long test-oldest test-pythons coverage attack derive audit check-generated bench lint docs test-page release clean

help:  ## list the targets
	@awk -F ':.*## ' '/^[a-z-]+:.*## / { printf "make %-16s %s\n", $$1, $$2 }' $(MAKEFILE_LIST)

optimise: $(VENV)/.runtime  ## set up, optimise the paper's planting device, write the report to out/
	$(BIN)/planter optimise wang2017 --out $(OUT)

# Assertions are not rewritten at first, which costs every process ten seconds; what fails runs again with its values.
test: $(VENV)/.complete  ## set up, run the whole test suite
	$(BIN)/python -m pytest --assert=plain || \
		{ $(BIN)/python -m pytest --last-failed --last-failed-no-failures none; exit 1; }

test-long: $(VENV)/.extras  ## what the suite samples, in full: proofs, mutants, searches, extras, the browser (half an hour)
	$(BIN)/python -m pytest -m long
	PLANTER_ATTACKS=3000 PLANTER_ATTACK_SEED=1 $(BIN)/python -m pytest tests/attack

coverage: $(VENV)/.complete  ## lines of planter/ and derive/ that the suite runs; under 95 % is an error (from Python 3.12 on as fast as the suite)
	COVERAGE_CORE=$$($(BIN)/python -c 'import sys; print("sysmon" if sys.version_info >= (3, 12) else "ctrace")') \
		$(BIN)/python -m pytest --cov

attack: $(VENV)/.complete  ## ten thousand files and words that nobody should hand in; kills, full disks, closed streams
	PLANTER_ATTACKS=10000 $(BIN)/python -m pytest -m "long or not long" tests/attack
	$(BIN)/python -m pytest -m fault tests/planter

test-oldest: $(OLDEST)/.complete  ## the interface and the commands with the oldest versions that are allowed
	$(OLDEST)/$(SCRIPTS)/python -m pytest -n 0 $(OUTSIDE)

test-pythons:  ## the same with every Python from 3.11 to 3.14 that is found, and the newest versions
	@found=; for version in $(PYTHONS); do \
		command -v python$$version >/dev/null || { echo "python$$version is not there: not tested" >&2; continue; }; \
		found=$$version; folder=$(VENV)-$$version; \
		python$$version -m venv --clear $$folder && \
		$$folder/$(SCRIPTS)/python -m pip --disable-pip-version-check install --quiet --constraint constraints.txt \
			--editable '.[derive,notebook,studio,parquet]' pytest pytest-xdist jsonschema psutil && \
		$$folder/$(SCRIPTS)/python -m pytest -n 0 $(OUTSIDE) || exit 1; done; test -n "$$found"

derive: $(VENV)/.derive  ## derive the equations, write generated/
	$(BIN)/python -m derive

audit: $(VENV)/.derive  ## judge the papers' equations, write their verdicts to generated/
	$(BIN)/python -m derive audit

check-generated: $(VENV)/.derive  ## derive again into a temporary folder, compare with generated/ both ways
	$(BIN)/python -m derive --check

bench: $(VENV)/.bench  ## time every way to evaluate a turn, write bench.json and the tables to out/
	$(BIN)/planter about bench --out $(OUT)

lint: $(VENV)/.complete  ## format check, lint, types; sizes and names, which may only fall
	$(BIN)/ruff format --check
	$(BIN)/ruff check
	$(BIN)/mypy
	$(BIN)/python -m tests.support.size --check

test-page: $(VENV)/.docs  ## the page without a server: what it computes, and in a browser
	$(BIN)/python -m pytest -n 0 tests/planter/kernels/test_programs.py tests/planter/studio/static

docs: $(VENV)/.docs  ## build the documentation into out/docs, without a network, every warning an error
	$(BIN)/python -m sphinx --fail-on-warning --keep-going --quiet docs $(OUT)/docs

release: $(VENV)/.complete  ## build sdist and wheel in dist/, test them in empty environments; nothing is uploaded
	rm -rf dist
	$(BIN)/python -m hatchling build -d dist
	PLANTER_DIST=dist $(BIN)/python -m pytest -n 0 -m "long or not long" tests/test_release.py tests/test_wheel.py

clean:  ## remove the virtual environments, caches and results
	rm -rf $(VENV) $(VENV)-* $(OUT) dist .mypy_cache .pytest_cache .ruff_cache
	find derive generated planter tests -type d -name __pycache__ -prune -exec rm -rf {} +

# Stamps: what a user of the command needs, what a derivation needs, everything that tests and lint need, a notebook's
# page, the documentation, and the benchmark's peers.
$(VENV)/.runtime: $(VENV)/.created
	$(PIP) --editable .
	@touch $@

$(VENV)/.derive: $(VENV)/.created
	$(PIP) --editable '.[derive]'
	@touch $@ $(VENV)/.runtime

$(VENV)/.complete: $(VENV)/.created
	$(PIP) --editable '.[derive,test,dev]'
	@touch $@ $(VENV)/.runtime $(VENV)/.derive

# An extra that the package index does not offer here is left out; the tests that want it are skipped and say so.
$(VENV)/.extras: $(VENV)/.complete
	@for extra in $(EXTRAS); do \
		$(PIP) --editable ".[$$extra]" || echo "planter[$$extra] cannot be installed here: its tests are skipped" >&2; done
	@touch $@

$(VENV)/.docs: $(VENV)/.complete
	$(PIP) --editable '.[derive,notebook,docs]'
	@touch $@

$(VENV)/.bench: $(VENV)/.created
	$(PIP) --editable '.[derive,bench]'
	@touch $@ $(VENV)/.runtime

$(OLDEST)/.complete: $(SETUP) constraints-oldest.txt
	$(PYTHON) -m venv --clear $(OLDEST)
	$(OLDEST)/$(SCRIPTS)/python -m pip --disable-pip-version-check install --quiet --constraint constraints-oldest.txt \
		--editable '.[derive,notebook,studio,parquet]' pytest pytest-xdist jsonschema psutil
	@touch $@

$(VENV)/.created: $(SETUP)
	@command -v $(PYTHON) >/dev/null || { \
		echo "planter needs Python 3.11 or newer, and there is no '$(PYTHON)': make PYTHON=/path/to/python" >&2; exit 1; }
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || { \
		echo "planter needs Python 3.11 or newer, and '$(PYTHON)' is $$($(PYTHON) --version 2>&1):" \
			"make PYTHON=/path/to/python" >&2; exit 1; }
	$(PYTHON) -m venv --clear $(VENV)
	@touch $@
