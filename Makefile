# These names are the ones that .ci/run calls. All that is installed goes into .venv, made on first use.
VENV := .venv
BIN := $(VENV)/bin
KOUSOKU := $(BIN)/kousoku
TESTS ?= tests
# The tests of a file share what its fixtures make, so that they stay in one process.
PYTEST := $(BIN)/python -m pytest --numprocesses auto --dist loadfile --quiet

# Each stamp remembers one set of extras; a changed pyproject.toml installs them again.
installed = $(VENV)/.has-$(1)

.PHONY: demo quick test release-test slow lint types generate-check notebook notebooks ledger bench bench-solvers compiler clean
.NOTPARALLEL:

demo: $(call installed,plot)  ## derive, emit, verify, solve the mechanisms of the 1981 paper, draw
	$(KOUSOKU) generate
	$(KOUSOKU) verify
	$(KOUSOKU) solve scenes/piston_crank.toml --plot plots
	$(KOUSOKU) solve scenes/lever_crank.toml --plot plots

quick: $(call installed,test)  ## while you work: no compiler, a minute at most
	$(PYTEST) --quick $(TESTS)

test: $(call installed,test)  ## for every change: all that must hold on a user's machine
	$(PYTEST) -m "not release" $(TESTS)

release-test: $(call installed,test) $(call installed,browser)  ## besides: all proofs, notebooks, packaging, reproducibility
	$(PYTEST) -m release $(TESTS)

slow: $(call installed,test)  ## measure which tests take too long for quick
	$(BIN)/python -m pytest --quiet -m "not (compiles or numpy_solver or release)" --record-slow $(TESTS)

lint: $(call installed,lint)
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/clang-format --dry-run -Werror runtime/*/*.h

types: $(call installed,test) $(call installed,lint)
	$(BIN)/mypy

generate-check: $(call installed,plot)  ## the committed generated/ is what the generator emits today
	$(KOUSOKU) generate --check

notebooks: $(call installed,test)  ## execute the notebooks again and compare their outputs
	$(BIN)/python -m pytest --quiet tests/release/test_notebooks.py

notebook: $(call installed,notebook)  ## open the first mechanism in Jupyter
	$(BIN)/jupyter lab notebooks/first_mechanism.ipynb

ledger: $(call installed,test)  ## write the ledger's index and pages anew, after its entries
	$(BIN)/python -m kousoku.ledger.index
	$(KOUSOKU) ledger --latex >docs/ledger.tex
	$(KOUSOKU) ledger --markdown >docs/ledger.md
	$(BIN)/python -m pytest --quiet --update-golden tests/ledger/test_proofs.py

bench: $(call installed,bench)  ## the speed of a kernel, beside CasADi, heyoka, SymForce and lambdify
	$(BIN)/python benchmarks/kernels.py

bench-solvers: $(call installed,bench)  ## the speed of scenes' solvers, beside Exudyn and Pinocchio
	$(BIN)/python benchmarks/solvers.py

compiler: $(call installed,compiler)  ## a C compiler as a Python package

clean:
	rm -rf $(VENV) build dist plots

$(VENV)/.has-%: pyproject.toml
	@set -e; found=; for python in $(PYTHON) python3 python3.14 python3.13 python3.12 python3.11 python; do \
	  if $$python -c 'import sys; sys.exit(sys.version_info < (3, 11))' 2>/dev/null; then found=$$python; break; fi; \
	done; \
	test -n "$$found" || { echo "kousoku needs Python 3.11 or newer; name one: make PYTHON=/path/to/python3" >&2; exit 2; }; \
	test -x $(BIN)/pip || $$found -m venv --clear $(VENV); \
	echo "installing kousoku[$*] into $(VENV)"; \
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --editable ".[$*]"; \
	touch $@
