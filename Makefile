# make demo   a woman's voice from one command, with its report and its sound
# make test   the fast half of the tests: exact properties, rates, second algorithms, every command once
# make check  all tests; begins with make test
# make docs   the documentation as a site, with the tutorials run
# make wheel  wheels that run on any Linux of the last years, each proved where there is Python alone
# Each sets up what is missing (Debian packages, a virtual environment, the build) and is quick when
# repeated. Variables: PYTHON (3.11 or later), DEMO_SCENE, DEMO_DIR, PYTEST_ARGS, WHEELS.
PYTHON ?= python3
DEMO_SCENE ?= examples/speaking.toml
DEMO_DIR ?= runs/demo
# Debian's releases with the Pythons that wheels are for: 3.11 and 3.13.
WHEELS ?= bookworm trixie
PYTEST_ARGS ?= --numprocesses auto --dist loadfile

# Builds in other directories share what they compile.
export CCACHE_BASEDIR ?= $(CURDIR)
export CCACHE_NOHASHDIR ?= 1

BUILD := build/release
VENV := .venv
BIN := $(VENV)/bin
PIP := $(BIN)/python -m pip --disable-pip-version-check --quiet
LAUNCHER = $(if $(shell command -v ccache),-Ccmake.define.CMAKE_CXX_COMPILER_LAUNCHER=ccache)

ENGINE_SOURCES := CMakeLists.txt pyproject.toml $(wildcard cmake/* examples/*) \
  $(shell find cpp python/bindings -name '*.[ch]pp' -o -name CMakeLists.txt)

.PHONY: help build demo test test-cpp test-python check test-slow stub docs wheel tables bench-peers format clean FORCE
.DELETE_ON_ERROR:

help:
	@sed -n '1,/^PYTHON/{s/^# //p}' Makefile

# ---- Set-up ----------------------------------------------------------------------------------
$(VENV)/packages.stamp: .ci/packages
	@PYTHON=$(PYTHON) .ci/packages
	@mkdir -p $(VENV) && touch $@

$(VENV)/environment.stamp: pyproject.toml .ci/requirements | $(VENV)/packages.stamp
	@echo "plica: setting up $(VENV)"
	@$(PYTHON) -m venv $(VENV)
	@$(BIN)/python .ci/requirements > $(VENV)/requirements.txt
	@$(PIP) install -r $(VENV)/requirements.txt
	@touch $@

# The list of Python files: a new or removed one renews the installation, an edited one does not need to.
$(VENV)/modules.txt: FORCE | $(VENV)/packages.stamp
	@find python/plica -name '*.py' -o -name '*.typed' -o -name '*.pyi' -o -name '*.j2' -o -path 'python/plica/viewer/*' -type f | sort > $@.new
	@cmp -s $@.new $@ || cp $@.new $@; rm -f $@.new

$(VENV)/engine.stamp: $(ENGINE_SOURCES) $(VENV)/environment.stamp $(VENV)/modules.txt
	@echo "plica: building the engine"
	@$(PIP) install --no-build-isolation --no-deps --editable . \
	  -Cbuild-dir=$(BUILD) -Ccmake.define.PLICA_TESTS=ON $(LAUNCHER)
	@touch $@

build: $(VENV)/engine.stamp

# ---- What people type ------------------------------------------------------------------------
# A fresh run each time; the one before is kept as $(DEMO_DIR).previous.
demo: build
	@if [ -e $(DEMO_DIR) ]; then rm -rf $(DEMO_DIR).previous && mv $(DEMO_DIR) $(DEMO_DIR).previous; fi
	@mkdir -p $(dir $(DEMO_DIR))
	$(BIN)/plica run $(DEMO_SCENE) -o $(DEMO_DIR)
	@test -e $(DEMO_DIR)/report.html || $(BIN)/plica report $(DEMO_DIR)
	@echo "report: $(CURDIR)/$(DEMO_DIR)/report.html"

test: test-cpp test-python

test-cpp: build
	@cmake --build $(BUILD) --target plica_tests
	@ctest --test-dir $(BUILD) --output-on-failure --parallel $$(nproc)

# A file's tests run in one process, so that what they share is computed once; a process for each processor, whose
# dense algebra would only wait for others with threads of its own.
test-python test-slow: export OPENBLAS_NUM_THREADS = 1
test-python: build
	@$(BIN)/python -m pytest $(PYTEST_ARGS) -m "not slow"

# In this order also with make --jobs.
check: test
	@$(MAKE) --no-print-directory test-slow

test-slow: build
	@$(BIN)/python -m pytest $(PYTEST_ARGS) -m slow

# ---- What developers type --------------------------------------------------------------------
stub: build
	@.ci/stub python/plica/_engine.pyi

# The site, in build/docs/html; runs the tutorials.
docs: build
	@$(BIN)/python -m sphinx --fail-on-warning --keep-going --quiet -b html docs build/docs/html
	@echo "docs: $(CURDIR)/build/docs/html/index.html"

# In dist/; what it stands on is in build/wheel.
wheel:
	@$(PYTHON) .ci/wheel $(WHEELS)

# The tables of all records of docs, as Markdown and as CSV.
tables: build
	@$(BIN)/python -m benchmarks tables

# What the benchmarks measure beside plica, in an environment of its own.
bench-peers: build
	@.ci/bench_peers

format: build
	@find cpp python/bindings tests examples -name '*.[ch]pp' | xargs $(BIN)/clang-format -i
	@$(BIN)/ruff format --quiet python tests benchmarks examples
	@$(BIN)/ruff check --quiet --fix python tests benchmarks examples

clean:
	rm -rf build build-sanitize dist $(VENV) .venv-peers
