# Every target makes .venv and installs what it needs, once for each change of pyproject.toml or constraints.txt.
PYTHON ?= python3
BIN := .venv/bin
INPUTS ?= 100000
SEED ?= 0
ATTACKS ?=

EXACT := PYTHONPATH=tests $(BIN)/python -m support.exactness

.PHONY: help bench test lint fuzz benchmark docs exact exact-arm64 interop cluster kills interrupts

help:
	@echo "make bench      score the agents of the quick suite, print their leaderboard and compare it with the published one"
	@echo "make test       run the tests"
	@echo "make lint       check style, types and the direction of imports"
	@echo "make fuzz       give hostile input to all that reads some, INPUTS times, in all ways or as ATTACKS says"
	@echo "make benchmark  measure the simulator's speed, next to its peers'"
	@echo "make docs       write the API documentation, one page a module, into site/"
	@echo "make exact      compare trajectories, decisions and trainings with those of kernels for a plain x86-64 processor"
	@echo "make exact-arm64 compare them with those of an emulated ARM64 one; needs Debian's qemu-user-static and mmdebstrap"
	@echo "make interop    train with RLlib, which pins an older Gymnasium, in .venv-ray, and with other trackers, in .venv-trackers"
	@echo "make cluster    run a suite on a Ray cluster of three nodes and kill one, in .venv-ray"
	@echo "make kills      kill a run at twenty random moments, and resume it each time"
	@echo "make interrupts press Ctrl-C at two hundred random moments of evaluate, train and run"

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
	OMP_NUM_THREADS=1 PYTHONPATH=tests $(BIN)/python -m support.fuzzing $(INPUTS) $(SEED) $(ATTACKS)

benchmark: .venv/installed-peers
	$(BIN)/pytest tests/benchmarks -p no:xdist --benchmark-columns=min,median,rounds

docs: .venv/installed-docs
	$(BIN)/python docs/api.py site

exact: .venv/installed
	mkdir -p runs/exact
	$(EXACT) > runs/exact/here
	NUMBA_CPU_NAME=x86-64 NUMBA_CPU_FEATURES= NUMBA_CACHE_DIR=runs/exact/kernels $(EXACT) > runs/exact/plain
	diff runs/exact/here runs/exact/plain && echo "equal: all $$(wc -l < runs/exact/here) digests"

exact-arm64: .venv/installed .venv-arm64/installed
	mkdir -p runs/exact
	$(EXACT) > runs/exact/here
	qemu-aarch64-static -L .venv-arm64/root -E NUMBA_CACHE_DIR=runs/exact/arm64-kernels \
		-E PYTHONPATH=.venv-arm64/site:.:agents:environments:tests \
		.venv-arm64/root/usr/bin/python3 -m support.exactness > runs/exact/arm64
	diff runs/exact/here runs/exact/arm64 && echo "equal: all $$(wc -l < runs/exact/here) digests"

interop: .venv-ray/installed-interop .venv-trackers/installed
	OMP_NUM_THREADS=1 .venv-ray/bin/pytest -o filterwarnings=error tests/envs/views/test_interop_rllib.py
	OMP_NUM_THREADS=1 .venv-trackers/bin/pytest -o filterwarnings=default tests/bench/training/test_other_trackers.py

cluster: .venv-ray/installed-interop
	.venv-ray/bin/pytest -o filterwarnings=error tests/bench/execution/test_ray_cluster.py

kills: .venv/installed-dev
	HHRL_KILLS=20 $(BIN)/pytest tests/bench/execution/test_killed_sweeps.py

interrupts: .venv/installed-dev
	HHRL_PRESSES=200 $(BIN)/pytest tests/bench/cli/test_interrupts.py

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

.venv-trackers/installed: pyproject.toml constraints-trackers.txt
	test -x .venv-trackers/bin/python || $(PYTHON) -m venv .venv-trackers
	.venv-trackers/bin/pip install --quiet --disable-pip-version-check --constraint constraints-trackers.txt \
		--editable '.[wandb,mlflow]' pytest
	touch $@

# Debian 12's Python 3.11 for ARM64, unpacked, and wheels for it; nothing of it needs root.
.venv-arm64/installed: pyproject.toml constraints.txt
	rm -rf .venv-arm64 && mkdir .venv-arm64
	mmdebstrap --quiet --architectures=arm64 --variant=extract --include=python3,libstdc++6 bookworm .venv-arm64/root
	$(BIN)/pip install --quiet --disable-pip-version-check --target .venv-arm64/site --constraint constraints.txt \
		--only-binary=:all: --python-version 3.11 --platform manylinux_2_28_aarch64 --platform manylinux2014_aarch64 \
		$$($(BIN)/python -c "import tomllib; print(*tomllib.load(open('pyproject.toml', 'rb'))['project']['dependencies'])")
	touch $@
