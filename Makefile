# make demo   map the log that ships with rgviz and open it in the browser  (PORT=8080 HOST=127.0.0.1)
# make test   all tests, the browser suite included
# make check  format, lint, types      make bench  benchmarks (slow; nothing is asserted)
# Each target installs what it needs into .venv by itself.

PYTHON ?= python3
HOST ?= 127.0.0.1
PORT ?= 8080
VENV := .venv
PY := $(VENV)/bin/python
ARGS ?=

.PHONY: demo test check format bench picture clean
.DEFAULT_GOAL := demo

demo: $(VENV)/.app
	$(VENV)/bin/rgviz demo --host $(HOST) --port $(PORT) $(ARGS)

test: $(VENV)/.dev
	@sh tests/browser/chromium.sh
	@sh tests/exports/validator.sh $(VENV)
	$(PY) -m pytest $(ARGS)

check: $(VENV)/.dev
	$(VENV)/bin/ruff format --check .
	$(VENV)/bin/ruff check .
	$(VENV)/bin/mypy

format: $(VENV)/.dev
	$(VENV)/bin/ruff format .
	$(VENV)/bin/ruff check --fix .

bench: $(VENV)/.dev
	@for f in tests/bench/bench_*.py; do echo "== $$f"; $(PY) $$f || exit 1; done

$(VENV)/bin/python:
	$(PYTHON) -c 'import sys; sys.exit(0 if sys.version_info >= (3, 10) else "rgviz needs Python 3.10 or newer, this is %s; name another: make PYTHON=python3.12" % sys.version.split()[0])'
	$(PYTHON) -m venv $(VENV)

# Compiling once here keeps the first map free of waiting.
$(VENV)/.app: pyproject.toml | $(VENV)/bin/python
	$(PY) -m pip install --quiet --disable-pip-version-check -e .
	$(VENV)/bin/rgviz compile
	@touch $@

$(VENV)/.dev: pyproject.toml | $(VENV)/bin/python
	$(PY) -m pip install --quiet --disable-pip-version-check -e '.[dev]'
	$(VENV)/bin/rgviz compile
	@touch $@

# The pictures in README and docs, made by the project itself.
picture: $(VENV)/.dev
	@sh tests/browser/chromium.sh
	$(PY) tests/browser/picture.py docs

clean:
	rm -rf $(VENV) build dist .pytest_cache .mypy_cache .ruff_cache .hypothesis out
