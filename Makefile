# Every target makes .venv by itself, once, and needs nothing done before.

RANKS ?= $(shell [ "$$(nproc 2>/dev/null || echo 1)" -lt 2 ] && echo 1 || echo 2)
PYTHON_HERE = .venv/bin/python
READY = .venv/.ready

# One thread a rank: OpenBLAS threads would compete with the ranks for the same cores.
export OMP_NUM_THREADS = 1
# Nothing outside .venv may be imported from within it.
unexport PYTHONPATH PYTHONHOME
export PYTHONNOUSERSITE = 1

# Tests compile a thousand forms and compute little with each: half an optimization, and no symbols
# for a debugger, with which the largest form takes three times as long.
FOR_TESTS = STAFFA_CFLAGS="-O1 -g0"
SHARED_OUT = -n $(RANKS) --dist worksteal
.PHONY: help demo demo3d check lint types quick test test-serial test-mpi docs linkcheck coverage
.PHONY: bench verify format clean reservoir FORCE
.NOTPARALLEL:

help:
	@echo "make demo    crack a cooled slab on $(RANKS) rank(s), into runs/demo (RANKS=n to change)"
	@echo "make demo3d  columns in a cooled block, likewise, into runs/demo3d; half an hour on one core, by staffa check"
	@echo "make reservoir  the reservoir simulator open-DARTS, into .reservoir; 1.1 GB, some minutes"
	@echo "make check   format, lint, measures of the code and types; no tests, which are in make test"
	@echo "make quick   the fast tests alone"
	@echo "make test    run every test, the fast ones too, but those of minutes, which make verify runs"
	@echo "make docs    build the site of the documentation into build/docs, its notebooks executed"
	@echo "make linkcheck  ask whether the outside links of the docs are there"
	@echo "make coverage  the tests of one rank, with the lines that they leave out"
	@echo "make bench   staffa beside a hand-written script, case by case; takes hours"
	@echo "make verify  long verifications against references, into docs/verification.md; takes hours"
	@echo "make format  rewrite the code in the house format"
	@echo "make clean   delete .venv, .reservoir and caches, keep runs/"

demo: $(READY)
	rm -rf runs/demo
	.venv/bin/mpiexec -n $(RANKS) .venv/bin/staffa demo

demo3d: $(READY)
	rm -rf runs/demo3d
	.venv/bin/mpiexec -n $(RANKS) .venv/bin/staffa run src/staffa/case/ready/brick.toml --out runs/demo3d

# A separate environment: open-DARTS needs other versions than .venv, and has no wheel for 3.14.
reservoir:
	@tools/reservoir.sh

check: lint types

lint: $(READY)
	$(PYTHON_HERE) -m ruff format --check
	$(PYTHON_HERE) -m ruff check
	$(PYTHON_HERE) tools/measure_code.py

types: $(READY)
	$(PYTHON_HERE) -m mypy

quick: $(READY)
	$(FOR_TESTS) $(PYTHON_HERE) -m pytest $(SHARED_OUT) -m "not slow and not mpi and not long"

test: test-serial test-mpi

test-serial: $(READY)
	$(FOR_TESTS) $(PYTHON_HERE) -m pytest $(SHARED_OUT) -m "not mpi and not long"

# Those of several ranks have the cores for themselves: the ranks of MPICH spin while they wait.
test-mpi: $(READY)
	$(FOR_TESTS) $(PYTHON_HERE) -m pytest tests/mpi -m "not long"

# Notebooks are executed; a warning is an error.
docs: $(READY)
	$(FOR_TESTS) $(PYTHON_HERE) -m sphinx --builder html --fail-on-warning --keep-going --quiet docs build/docs
	@cat build/docs/notebook-times.txt
	@echo "open build/docs/index.html in a browser"

# Asks the servers of all outside links, so it is no part of any test.
linkcheck: $(READY)
	$(PYTHON_HERE) -m sphinx --builder linkcheck -D nb_execution_mode=off -D suppress_warnings=myst-nb.lexer docs build/linkcheck

# The floor is in pyproject.toml.
coverage: $(READY)
	$(FOR_TESTS) $(PYTHON_HERE) -m pytest $(SHARED_OUT) -m "not mpi and not long" --cov --cov-report=term:skip-covered

# CASES="A120k C120k D300k:2" runs these alone.
bench: $(READY)
	$(PYTHON_HERE) -m bench.yardstick.run $(CASES)
	[ -n "$(CASES)" ] || $(PYTHON_HERE) -m bench.startup.run
	[ -n "$(CASES)" ] || $(PYTHON_HERE) -m bench.presets.run
	[ -n "$(CASES)" ] || $(PYTHON_HERE) -m bench.second_order.run
	[ -n "$(CASES)" ] || $(PYTHON_HERE) -m bench.split.run
	[ -n "$(CASES)" ] || $(PYTHON_HERE) -m bench.scaling.run
	[ -n "$(CASES)" ] || $(PYTHON_HERE) -m bench.growth.run
	[ -n "$(CASES)" ] || $(PYTHON_HERE) -m bench.circulation.run

# ONLY="second-order array-free" runs these alone.
verify: $(READY)
	[ -n "$(ONLY)" ] || $(FOR_TESTS) $(PYTHON_HERE) -m pytest -m long
	[ -n "$(ONLY)" ] || STAFFA_FUZZ=250 $(PYTHON_HERE) -m pytest tests/case/test_fuzz.py
	$(PYTHON_HERE) -m verification $(ONLY)

format: $(READY)
	$(PYTHON_HERE) -m ruff check --select I --fix
	$(PYTHON_HERE) -m ruff format

clean:
	rm -rf .venv .reservoir build dist .mypy_cache .pytest_cache .ruff_cache .coverage src/*.egg-info
	find src tests verification bench -name __pycache__ -type d -prune -exec rm -rf {} + 2>/dev/null || true

# The stamp holds the folder that the environment was made in: a copy of the tree that took
# .venv along would import the original's code.
ifneq ($(shell cat $(READY) 2>/dev/null),$(CURDIR))
$(READY): FORCE
endif
$(READY): pyproject.toml constraints.txt tools/setup.sh
	@tools/setup.sh
