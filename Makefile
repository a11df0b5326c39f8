# `make demo` and `make test` set up all they need in .venv; both are quick the second time.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
OMA_MSGS := $(shell find oma_msgs tf2_msgs -name build -prune -o -type f -print)
CONTROL_MSGS := $(shell find control_msgs -name build -prune -o -type f -print)

# Two BLAS threads make the small LAPACK calls of modal analysis ten times slower than one.
export OPENBLAS_NUM_THREADS := 1
export OMP_NUM_THREADS := 1
export MKL_NUM_THREADS := 1

.PHONY: help demo test test-all test-core test-nodes coverage lint docs bench reproduce gap-matrix setup wheels clean

help:
	@echo 'make demo    set up and run the whole loop on the emulated arm'
	@echo 'make test    set up and run the tests, without the long ones and the series of nodes (ten minutes and more)'
	@echo 'make test-all   all tests, the long statistical and node series too (an hour)'
	@echo 'make coverage   which lines the quick tests without nodes run'
	@echo 'make lint    ruff and mypy'
	@echo 'make docs    build the documentation: docs/_build/html/index.html'
	@echo 'make bench   compare with the peers (installs them in $(VENV)-bench); BENCH=--full for hours, BENCH=faults for random faults, BENCH=families for random structures, BENCH=operation for an arm that mills'
	@echo 'make reproduce   compute the findings of the paper anew (under ten minutes of one core)'
	@echo 'make gap-matrix   hide effects in arms of a multibody engine and of our own, and count what is named (two hours)'
	@echo 'make wheels  the suite and the messages it needs, as wheels: dist/*.whl'
	@echo 'make clean   remove what was set up'

demo: setup
	$(BIN)/ama demo

# Two workers, each with its own ROS domains; a file stays on one, with its nodes and rigs.
TWO := -n 2 --dist loadfile

test: $(VENV)/.test-ready
	$(BIN)/python -m pytest $(TWO) -m 'smoke or not (slow or node)'

# Nodes run alone: series fail links on purpose, hold keys down, and wait for time-outs.
test-all: test-core
	@$(MAKE) test-nodes

test-core: $(VENV)/.test-ready
	$(BIN)/python -m pytest $(TWO) -m 'not node'

test-nodes: $(VENV)/.test-ready
	$(BIN)/python -m pytest -m node

coverage: $(VENV)/.test-ready
	$(BIN)/python -m pytest -q $(TWO) -m 'not slow and not node' --cov --cov-report=term:skip-covered

lint: $(VENV)/.test-ready
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy

WHEELS ?= dist

# The suite and the messages that PyPI lacks, for an empty environment.
wheels:
	$(PYTHON) -m pip wheel --quiet --no-deps --wheel-dir $(WHEELS) . ./oma_msgs ./tf2_msgs ./control_msgs
	@echo '$(WHEELS)/*.whl'

setup: $(VENV)/.ready

$(VENV)/bin/python:
	@scripts/check_system.sh $(PYTHON)
	$(PYTHON) -m venv $(VENV)

$(VENV)/.ready: setup.py $(VENV)/.messages | $(VENV)/bin/python
	@echo 'Setting up the suite in $(VENV) ...'
	$(BIN)/pip install --quiet --disable-pip-version-check --editable '.[ros]'
	@touch $@

$(VENV)/.messages: $(OMA_MSGS) | $(VENV)/bin/python
	@echo 'Building oma_msgs and tf2_msgs (about a minute each) ...'
	$(BIN)/pip install --quiet --disable-pip-version-check ./oma_msgs ./tf2_msgs
	@touch $@

# What ROS wheels of PyPI lack, for robots under ros2_control.
$(VENV)/.control-messages: $(CONTROL_MSGS) | $(VENV)/bin/python
	@echo 'Building control_msgs (about a minute) ...'
	$(BIN)/pip install --quiet --disable-pip-version-check ./control_msgs
	@touch $@

$(VENV)/.test-ready: $(VENV)/.ready $(VENV)/.control-messages
	@echo 'Setting up what the tests need ...'
	$(BIN)/pip install --quiet --disable-pip-version-check --editable '.[ros,test]'
	@touch $@

$(VENV)-bench/.ready: setup.py $(VENV)/.messages
	$(PYTHON) -m venv $(VENV)-bench
	$(VENV)-bench/bin/pip install --quiet --disable-pip-version-check --editable '.[bench]'
	@touch $@

bench: $(VENV)-bench/.ready
	$(VENV)-bench/bin/python -m benchmarks $(BENCH)

docs: $(VENV)/.docs-ready
	$(BIN)/python -m sphinx -W --keep-going -q -j auto -b html docs docs/_build/html
	@echo 'docs/_build/html/index.html'

reproduce: $(VENV)/.docs-ready
	$(BIN)/python -m examples.paper

$(VENV)/.docs-ready: $(VENV)/.ready
	@echo 'Setting up what the documentation needs ...'
	$(BIN)/pip install --quiet --disable-pip-version-check --editable '.[ros,docs]'
	@touch $@

gap-matrix: $(VENV)-bench/.ready
	$(VENV)-bench/bin/python -m benchmarks.gap.at_rest
	$(VENV)-bench/bin/python -m benchmarks.gap.rates --seeds 2 --minutes 80 --out gap_rates.json
	$(VENV)-bench/bin/python -m benchmarks.gap.matrix --quick --minutes 35 --out gap_matrix.json

clean:
	rm -rf docs/_build docs/reference/generated $(VENV) $(VENV)-bench $(VENV)-oldest $(VENV)-older build *.egg-info oma_msgs/build tf2_msgs/build control_msgs/build
