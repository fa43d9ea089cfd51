.PHONY: setup demo test test-all lint style clean

READY := .venv/.ready
PYTHON ?= python3

# Some two hundred processes start in a run; without bytecode each would compile the package anew.
unexport PYTHONDONTWRITEBYTECODE

setup: $(READY)

$(READY): .ci/setup .ci/requirements.txt .ci/requirements-ros.txt .ci/constraints-ros.txt \
          .ci/drop_missing_include_dirs.cmake setup.py setup.cfg $(shell find msg_defs -type f)
	PYTHON=$(PYTHON) bash .ci/setup

demo: $(READY)
	bash .ci/demo

# One worker more than cores: the tests of nodes wait for most of their time. Those of a quick
# file share what it has made once (those of nodes and pages, of a folder), and those of nodes come
# first; long tests take minutes each.
# Where a worker of a quick run crashes, pytest-xdist 3.8 would wait for it for ever.
PYTEST := .venv/bin/python -m pytest -n $$(($$(nproc) + 1))

# Types are checked beside the first tests: that takes one core half a minute in a fresh clone.
# How large the code is `make lint` says; no change is refused for it.
test: style
	.venv/bin/mypy & \
	$(PYTEST) --dist loadfile --no-loadscope-reorder --max-worker-restart 0 -m "not long" tests \
	&& wait $$!

test-all: test
	$(PYTEST) --dist worksteal -m long tests
	.venv/bin/python -m lab.trials

CODE := ros_pose_stats tests study lab launch .ci setup.py

lint: style
	.venv/bin/python -m tests.house.weight
	.venv/bin/mypy

style: $(READY)
	.venv/bin/ruff check --config .ci/ruff.toml $(CODE)
	.venv/bin/ruff format --check --config .ci/ruff.toml $(CODE)

clean:
	rm -rf .venv build install log demo
