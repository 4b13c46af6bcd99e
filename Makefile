# Every target makes .venv and installs what it needs, once for each change of pyproject.toml or constraints.txt.
PYTHON ?= python3
BIN := .venv/bin
INPUTS ?= 100000

.PHONY: help bench test lint fuzz benchmark docs interop cluster kills

help:
	@echo "make bench      score the agents of the quick suite, print their leaderboard and compare it with the published one"
	@echo "make test       run the tests"
	@echo "make lint       check style, types and the direction of imports"
	@echo "make fuzz       give hostile input to all that reads some, INPUTS times"
	@echo "make benchmark  measure the simulator's speed, next to its peers'"
	@echo "make docs       write the API documentation, one page a module, into site/"
	@echo "make interop    train with RLlib, which pins an older Gymnasium, in .venv-ray"
	@echo "make cluster    run a suite on a Ray cluster of three nodes and kill one, in .venv-ray"
	@echo "make kills      kill a run at twenty random moments, and resume it each time"

bench: .venv/installed
	$(BIN)/hhrl-bench run --suite quick

test: .venv/installed-dev
	OMP_NUM_THREADS=1 $(BIN)/pytest --benchmark-disable -n 2

lint: .venv/installed-dev
	$(BIN)/ruff check
	$(BIN)/ruff format --check
	$(BIN)/mypy
	$(BIN)/lint-imports
	@! ls environments/*.py agents/*.py 2>/dev/null || { echo "move the files above into a package folder" >&2; false; }

fuzz: .venv/installed-dev
	OMP_NUM_THREADS=1 PYTHONPATH=tests $(BIN)/python -m support.fuzzing $(INPUTS)

benchmark: .venv/installed-peers
	$(BIN)/pytest tests/benchmarks -p no:xdist --benchmark-columns=min,median,rounds

docs: .venv/installed-docs
	$(BIN)/python docs/api.py site

interop: .venv-ray/installed-interop
	OMP_NUM_THREADS=1 .venv-ray/bin/pytest -o filterwarnings=error tests/envs/views/test_interop_rllib.py

cluster: .venv-ray/installed-interop
	.venv-ray/bin/pytest -o filterwarnings=error tests/bench/execution/test_ray_cluster.py

kills: .venv/installed-dev
	HHRL_KILLS=20 $(BIN)/pytest tests/bench/execution/test_killed_sweeps.py

.venv/installed: pyproject.toml constraints.txt
	test -x $(BIN)/python || $(PYTHON) -m venv .venv
	$(BIN)/pip install --quiet --disable-pip-version-check --constraint constraints.txt --editable .
	touch $@

.venv/installed-%: pyproject.toml constraints.txt
	test -x $(BIN)/python || $(PYTHON) -m venv .venv
	$(BIN)/pip install --quiet --disable-pip-version-check --constraint constraints.txt --editable '.[$*]'
	touch $@

.venv-ray/installed-interop: pyproject.toml constraints-interop.txt
	test -x .venv-ray/bin/python || $(PYTHON) -m venv .venv-ray
	.venv-ray/bin/pip install --quiet --disable-pip-version-check --constraint constraints-interop.txt --editable '.[interop]'
	touch $@
