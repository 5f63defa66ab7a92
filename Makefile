# make demo: from a fresh machine to the first video.   make test: the test suite.   make pictures: the README's.
# make gallery: docs/gallery.md; what OBJECTS lacks of other people's objects is fetched.
# make evidence: measured pages whose code has changed since, and how to measure them again.
PYTHON ?= python3
VENV ?= .venv
RUN := $(VENV)/bin
PYTEST_ARGS ?= -n auto --dist worksteal
DEMO_OUT ?= runs/demo
DEMO_PROMPT ?= a strong wind pushes the robot to the left

OBJECTS ?= runs/objects

# Containers often set it. Then each process compiles all that it imports, JAX's modules among them, and tests start many.
unexport PYTHONDONTWRITEBYTECODE

.PHONY: demo test lint pictures gallery evidence clean

demo: $(VENV)/.installed
	$(RUN)/physagent run --object examples/assets/robot.ply --prompt "$(DEMO_PROMPT)" --out $(DEMO_OUT) --overwrite

test: $(VENV)/.installed
	$(RUN)/python -m pytest $(PYTEST_ARGS)

lint: $(VENV)/.installed
	$(RUN)/ruff check .
	$(RUN)/ruff format --check .
	$(RUN)/pyright --pythonpath $(RUN)/python
	$(RUN)/lint-imports --no-logo
	$(RUN)/python .ci/check_writing.py

pictures: $(VENV)/.installed
	$(RUN)/python examples/make_pictures.py docs/images

gallery: $(VENV)/.installed
	$(RUN)/python -m benchmarks.gallery --objects $(OBJECTS)

evidence: $(VENV)/.installed
	$(RUN)/python -m benchmarks.evidence

$(VENV)/.installed: pyproject.toml
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || \
	  { echo "Python 3.11 or newer is needed; pass PYTHON=python3.x"; exit 2; }
	$(PYTHON) -m venv $(VENV)
	$(RUN)/python -m pip install --quiet --no-compile --editable '.[dev]'  # Python compiles what is imported
	touch $@

clean:
	rm -rf $(VENV) runs
