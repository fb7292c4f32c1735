# The verbs print themselves: `make` alone lists them.
PYTHON ?= python3.11
BIN := .venv/bin
export PIP_DISABLE_PIP_VERSION_CHECK := 1
export OPENBLAS_NUM_THREADS := 1
export OMP_NUM_THREADS := 1

.PHONY: help install demo test check bench docs clean
help:            ## this list
	@sed -n -E 's/^([a-z]+):[^#]*## *(.*)/  make \1\t\2/p' $(firstword $(MAKEFILE_LIST)) | expand -t 16

install: .venv/installed  ## the environment .venv with graben and all it needs

# Strict editable installs link files one by one: a new file needs a re-install, so the list of files is a need.
SOURCES := $(wildcard core/*.py core/*/*.py core/reports/templates/* cleaning/*.py cleaning/*/*.py modeling/*.py validators/*.py validators/*/*.py)
.venv/files: FORCE
	@mkdir -p .venv && echo "$(sort $(SOURCES))" | cmp -s - $@ || echo "$(sort $(SOURCES))" > $@
FORCE:

.venv/installed: pyproject.toml constraints.txt .venv/files
	test -x $(BIN)/python || $(PYTHON) -m venv .venv
	$(BIN)/python -m pip install --quiet --constraint constraints.txt setuptools wheel
	$(BIN)/python -m pip install --quiet --constraint constraints.txt --no-build-isolation \
	  --config-settings editable_mode=strict --editable ".[test]"
	touch $@

demo: install    ## writes a synthetic model, runs the whole pipeline on it, says where the report is
	rm -rf build/demo
	$(BIN)/graben demo single -o build/demo/single
	$(BIN)/graben run build/demo/single/model.toml -o build/demo/result
	@echo "report: build/demo/result/report.html"

check: install   ## ruff, mypy --strict, import-linter
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports

test: check      ## everything CI runs: check, doctests, tests
	$(BIN)/python -m pytest -q -n 2 --dist worksteal --doctest-modules --pyargs graben tests

bench: install   ## long benchmarks, into build/bench
	$(BIN)/python -m pip install --quiet --constraint constraints.txt --no-build-isolation \
	  --config-settings editable_mode=strict --editable ".[test,bench]"
	$(BIN)/python -m tests.bench

docs: install    ## the documentation, into build/docs
	$(BIN)/python -m pip install --quiet --constraint constraints.txt --no-build-isolation \
	  --config-settings editable_mode=strict --editable ".[test,docs]"
	$(BIN)/sphinx-build -W -b html docs build/docs

clean:           ## removes what was built
	rm -rf build .venv .mypy_cache .pytest_cache .ruff_cache .import_linter_cache
