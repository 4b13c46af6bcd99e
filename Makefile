# Every target makes .venv and installs what it needs, once for each change of pyproject.toml or of a list of versions.
PYTHON ?= python3
BIN := .venv/bin
INPUTS ?= 100000
SEED ?= 0
ATTACKS ?=
CLIENTS := zoo tianshou skrl benchmarl agilerl imitation

EXACT := PYTHONPATH=tests $(BIN)/python -m support.exactness

PIP_INSTALL := $(BIN)/pip install --quiet --disable-pip-version-check
LOCKED_INSTALL := $(PIP_INSTALL) --require-hashes --no-deps --requirement
LOCK := .venv-tools/bin/uv pip compile --quiet --no-config --upgrade --universal --python-version 3.11 --generate-hashes \
	--no-header --no-annotate
# What the lowest versions must do: the same trajectories, views and pictures, a command
LOWEST := tests/envs/simulation/test_golden.py tests/envs/views/test_triads.py tests/envs/rendering/test_rendering.py \
	tests/bench/figures/test_watch.py tests/bench/cli/test_streams.py

.PHONY: help install lowest bench test lint fuzz benchmark docs exact exact-arm64 interop cluster kills interrupts locks audit

help:
	@echo "make install    install the command line with all that it can use, into .venv"
	@echo "make bench      score the agents of the quick suite, print their leaderboard and compare it with the published one"
	@echo "make test       run the tests"
	@echo "make lint       check style, types and the direction of imports"
	@echo "make fuzz       give hostile input to all that reads some, INPUTS times, in all ways or as ATTACKS says"
	@echo "make benchmark  measure the simulator's speed, next to its peers'"
	@echo "make docs       write the API documentation, one page a module, into site/"
	@echo "make exact      compare trajectories, decisions and trainings with those of kernels for a plain x86-64 processor"
	@echo "make exact-arm64 compare them with those of an emulated ARM64 one; needs Debian's qemu-user-static and mmdebstrap"
	@echo "make interop    try libraries beside other versions: RLlib, RL Zoo, Tianshou, skrl, BenchMARL, AgileRL, imitation, trackers"
	@echo "make cluster    run a suite on a Ray cluster of three nodes and kill one, in .venv-ray"
	@echo "make kills      kill a run at twenty random moments, and resume it each time"
	@echo "make lowest     try the lowest versions that are declared, in .venv-lowest"
	@echo "make locks      write locks/ anew after a change of pyproject.toml or constraints.txt"
	@echo "make audit      ask which locked versions have known vulnerabilities"
	@echo "make interrupts press Ctrl-C at two hundred random moments of evaluate, train and run"

install: .venv/installed-all
	@echo "installed: $(BIN)/hhrl-bench"

bench: .venv/installed-bare
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

docs: .venv/installed-dev
	$(BIN)/python docs/api.py site

exact: .venv/installed-bare
	mkdir -p runs/exact
	$(EXACT) > runs/exact/here
	NUMBA_CPU_NAME=x86-64 NUMBA_CPU_FEATURES= NUMBA_CACHE_DIR=runs/exact/kernels $(EXACT) > runs/exact/plain
	diff runs/exact/here runs/exact/plain && echo "equal: all $$(wc -l < runs/exact/here) digests"

exact-arm64: .venv/installed-bare .venv-arm64/installed
	mkdir -p runs/exact
	$(EXACT) > runs/exact/here
	qemu-aarch64-static -L .venv-arm64/root -E NUMBA_CACHE_DIR=runs/exact/arm64-kernels \
		-E PYTHONPATH=.venv-arm64/site:.:agents:environments:tests \
		.venv-arm64/root/usr/bin/python3 -m support.exactness > runs/exact/arm64
	diff runs/exact/here runs/exact/arm64 && echo "equal: all $$(wc -l < runs/exact/here) digests"

interop: .venv-ray/installed-interop .venv-trackers/installed $(CLIENTS:%=.venv-clients/%/installed)
	OMP_NUM_THREADS=1 .venv-ray/bin/pytest -o filterwarnings=error tests/envs/views/test_interop_rllib.py
	OMP_NUM_THREADS=1 .venv-trackers/bin/pytest -o filterwarnings=default tests/bench/training/test_other_trackers.py
	for client in $(CLIENTS); do OMP_NUM_THREADS=1 .venv-clients/$$client/bin/pytest -o filterwarnings=error \
		tests/envs/views/test_interop_$$client.py || exit 1; done

cluster: .venv-ray/installed-interop
	.venv-ray/bin/pytest -o filterwarnings=error tests/bench/execution/test_ray_cluster.py

kills: .venv/installed-dev
	HHRL_KILLS=20 $(BIN)/pytest tests/bench/execution/test_killed_sweeps.py

interrupts: .venv/installed-dev
	HHRL_PRESSES=200 $(BIN)/pytest tests/bench/cli/test_interrupts.py

lowest: .venv-lowest/installed
	PYTHONPATH=tests .venv-lowest/bin/pytest -o filterwarnings= $(LOWEST)

locks: .venv-tools/installed
	set -e; for extra in bare all dev; do \
		$(LOCK) --constraint constraints.txt $$([ $$extra = bare ] || echo --extra $$extra) \
			pyproject.toml locks/build.in --output-file locks/$$extra.tmp > /dev/null; \
		awk -v torch=locks/torch.txt -f locks/split.awk locks/$$extra.tmp > locks/$$extra.txt; \
		rm locks/$$extra.tmp; \
	done
	$(LOCK) locks/tools.in --output-file locks/tools.txt > /dev/null

audit: .venv-tools/installed
	@set -e; for lock in all dev torch tools; do \
		echo "locks/$$lock.txt"; \
		.venv-tools/bin/pip-audit --strict --disable-pip --require-hashes --progress-spinner off -r locks/$$lock.txt || { \
			echo "make audit: see above; 'not found on PyPI' means that the list of vulnerabilities cannot be reached" >&2; \
			exit 1; \
		}; \
	done

# What is installed is what a lock says, to the byte: nothing is resolved, and nothing is built but the project itself.
.venv/installed-%: pyproject.toml locks/%.txt | $(BIN)/python
	$(LOCKED_INSTALL) locks/$*.txt
	$(PIP_INSTALL) --no-deps --no-build-isolation --editable .
	touch $@

.venv/installed-dev .venv/installed-all: .venv/installed-torch

.venv/installed-torch: locks/torch-cpu.txt locks/torch.txt | $(BIN)/python
	$(LOCKED_INSTALL) locks/torch-cpu.txt 2> /dev/null || $(LOCKED_INSTALL) locks/torch.txt
	touch $@

$(BIN)/python:
	$(PYTHON) -m venv .venv

.venv/installed-peers: pyproject.toml constraints.txt .venv/installed-dev
	$(PIP_INSTALL) --constraint constraints.txt --editable '.[peers]'
	touch $@

.venv-tools/installed: locks/tools.txt
	test -x .venv-tools/bin/python || $(PYTHON) -m venv .venv-tools
	.venv-tools/bin/pip install --quiet --disable-pip-version-check --require-hashes --no-deps --requirement locks/tools.txt
	touch $@

.venv-lowest/installed: pyproject.toml .venv-tools/installed
	.venv-tools/bin/uv venv --quiet --no-config --clear --python $(PYTHON) .venv-lowest
	.venv-tools/bin/uv pip install --quiet --no-config --python .venv-lowest/bin/python --resolution lowest-direct \
		--editable '.[render,report]' 'pytest>=8.3'
	touch $@

.venv-ray/installed-interop: pyproject.toml constraints-interop.txt
	test -x .venv-ray/bin/python || $(PYTHON) -m venv .venv-ray
	.venv-ray/bin/pip install --quiet --disable-pip-version-check --constraint constraints-interop.txt --editable '.[interop]'
	touch $@

.venv-clients/%/installed: pyproject.toml tests/interop/%.txt
	test -x .venv-clients/$*/bin/python || $(PYTHON) -m venv .venv-clients/$*
	.venv-clients/$*/bin/pip install --quiet --disable-pip-version-check --requirement tests/interop/$*.txt --editable .
	$(if $(NO_DEPS),.venv-clients/$*/bin/pip install --quiet --disable-pip-version-check --no-deps $(NO_DEPS))
	touch $@

# It asks for Gymnasium 0.29 and Stable-Baselines3 2.2, and runs with later ones.
.venv-clients/imitation/installed: NO_DEPS := imitation==1.0.1

.venv-trackers/installed: pyproject.toml constraints-trackers.txt
	test -x .venv-trackers/bin/python || $(PYTHON) -m venv .venv-trackers
	.venv-trackers/bin/pip install --quiet --disable-pip-version-check --constraint constraints-trackers.txt \
		--editable '.[wandb,mlflow]' pytest
	touch $@

# Debian 12's Python 3.11 for ARM64, unpacked, and wheels for it; nothing of it needs root.
.venv-arm64/installed: locks/bare.txt .venv/installed-bare
	rm -rf .venv-arm64 && mkdir .venv-arm64
	mmdebstrap --quiet --architectures=arm64 --variant=extract --include=python3,libstdc++6 bookworm .venv-arm64/root
	$(PIP_INSTALL) --target .venv-arm64/site --only-binary=:all: --python-version 3.11 \
		--platform manylinux_2_28_aarch64 --platform manylinux2014_aarch64 \
		--require-hashes --no-deps --requirement locks/bare.txt
	touch $@
