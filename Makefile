# make demo   set everything up, then turn a sentence into a judged robot motion on a virtual servo bus
#             (TORCH=cuda takes the PyTorch that pip finds, with its gigabytes of CUDA, instead of the CPU build)
# make test   set everything up, then run the tests
# make check  lint, format, types, import contracts
# make docs   build the site of docs/ into build/site; a warning is an error
# make mutants  put faults into the safety code, which the tests must notice (an hour)
# make clean  remove the environment and what the tools left behind

PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
STAMP := $(VENV)/.installed
PROMPT ?= a person waves with the right hand
OUT ?= out/demo
TORCH ?= cpu
TORCH_PIN := $(shell sed -n 's/^ *"\(torch==[^"]*\)".*/\1/p' pyproject.toml)
TORCH_INDEX := https://download.pytorch.org/whl/$(TORCH)
# What pip says goes into a log, from which progress is told.
PIP := $(BIN)/python -m pip install --disable-pip-version-check

.PHONY: demo test check docs mutants clean setup
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

docs: $(STAMP)
	$(PIP) --quiet --editable '.[docs]'
	NO_MKDOCS_2_WARNING=1 $(BIN)/python -m mkdocs build --clean --quiet

mutants: $(STAMP)
	$(BIN)/python -m tests.mutants.run

setup: $(STAMP)

$(STAMP): pyproject.toml
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' \
		|| { echo "error: Python 3.11 or newer is needed; name one with make PYTHON=/path/to/python3.11" >&2; exit 1; }
	@$(PYTHON) -c 'import ensurepip, venv' 2>/dev/null \
		|| { echo "error: Python's venv module is missing; on Debian or Ubuntu: apt install python3-venv" >&2; exit 1; }
	$(PYTHON) -m venv $(VENV)
	@echo "1 of 2: PyTorch for $(TORCH)"
ifeq ($(TORCH),cpu)
	@# Not every network reaches PyTorch's own index: what pip is configured for does as well.
	@$(PIP) --quiet --timeout 5 --retries 0 --index-url $(TORCH_INDEX) $(TORCH_PIN) 2>/dev/null \
		|| echo "PyTorch's index of CPU builds does not answer: taking what pip is configured for"
endif
	@echo "2 of 2: everything else (a few minutes; the environment ends at about 2.6 GB with the CPU build)"
	@$(PIP) --editable '.[dev]' > $(VENV)/install.log 2>&1 & pid=$$!; \
		while kill -0 $$pid 2>/dev/null; do sleep 2; \
			grep -oE '^Collecting [^ ;(]+' $(VENV)/install.log | sed 's/^Collecting /  /' > $(VENV)/now 2>/dev/null || true; \
			printf '\r\033[K  %s packages, %s' "$$(wc -l < $(VENV)/now)" "$$(du -sh $(VENV) | cut -f1)"; \
		done; printf '\n'; wait $$pid || { \
		if grep -qE 'Temporary failure|NameResolution|NewConnectionError|Connection|Could not find a version|timed out|No matching distribution' $(VENV)/install.log; then \
			echo "error: the package index does not answer: connect this machine, or set PIP_INDEX_URL (log: $(VENV)/install.log)" >&2; \
		else echo "error: installing failed: $$(grep -m1 -i '^error' $(VENV)/install.log) (log: $(VENV)/install.log)" >&2; fi; exit 1; }
	@touch $(STAMP)

clean:
	rm -rf $(VENV) out build *.egg-info .pytest_cache .ruff_cache .hypothesis .import_linter_cache
	find . -name __pycache__ -type d -prune -exec rm -rf {} +
