# Each target is a task of tasks.py, which does the same without make: python tasks.py demo
PYTHON ?= $(or $(firstword $(foreach name,python3 python3.14 python3.13 python3.12 python3.11 python,$(shell command -v $(name)))),python3)
TESTED := quick test release-test slow
TASKS := demo environment lint types generate-check notebook notebooks ledger stress bench compiler clean

.PHONY: $(TASKS) $(TESTED)
.NOTPARALLEL:

$(TASKS):
	@$(PYTHON) tasks.py $@

$(TESTED):
	@$(PYTHON) tasks.py $@ $(TESTS)
