.PHONY: setup demo test lint clean

READY := .venv/.ready
PYTHON ?= python3

setup: $(READY)

$(READY): .ci/setup .ci/requirements.txt setup.py setup.cfg
	PYTHON=$(PYTHON) bash .ci/setup

demo: $(READY)
	bash .ci/demo

test: lint
	.venv/bin/python -m pytest -n auto

lint: $(READY)
	.venv/bin/ruff check --config .ci/ruff.toml ros_pose_stats tests benchmarks setup.py
	.venv/bin/mypy

clean:
	rm -rf .venv build install log demo
