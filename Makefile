# make demo   set everything up, then turn a sentence into a judged robot motion on a virtual servo bus
# make test   set everything up, then run the tests
# make check  lint, format, types, import contracts
# make clean  remove the environment and what the tools left behind

PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
STAMP := $(VENV)/.installed
PROMPT ?= a person waves with the right hand
OUT ?= out/demo

.PHONY: demo test check clean setup
.DEFAULT_GOAL := demo

demo: $(STAMP)
	$(BIN)/python launch.py run "$(PROMPT)" --robot op3 --seed 0 --servo sim --out "$(OUT)"

test: $(STAMP)
	OMP_NUM_THREADS=1 $(BIN)/python -m pytest --numprocesses auto --dist loadfile --ignore tests/hw
	$(BIN)/python -m pytest tests/hw  # by themselves: their threads run ahead of all others

check: $(STAMP)
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/lint-imports
	$(BIN)/pyright

setup: $(STAMP)

$(STAMP): pyproject.toml
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' \
		|| { echo "error: Python 3.11 or newer is needed; name one with make PYTHON=/path/to/python3.11" >&2; exit 1; }
	@$(PYTHON) -c 'import ensurepip, venv' 2>/dev/null \
		|| { echo "error: Python's venv module is missing; on Debian or Ubuntu: apt install python3-venv" >&2; exit 1; }
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --editable '.[dev]'
	@touch $(STAMP)

clean:
	rm -rf $(VENV) out build *.egg-info .pytest_cache .ruff_cache .hypothesis .import_linter_cache
	find . -name __pycache__ -type d -prune -exec rm -rf {} +
