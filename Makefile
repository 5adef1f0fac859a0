# Two commands: `make study` runs the main job, `make test` the checks. Both set up .venv first, once.
PYTHON ?= python3
BIN := .venv/bin
# Python compiles a module when it is first imported: of most packages only a part.
INSTALL := $(BIN)/pip install --quiet --no-compile --constraint constraints.txt
# Files in the order of tests/conftest.py, not by their numbers of tests.
TWO_WORKERS := -n 2 --dist loadfile --no-loadscope-reorder
BUILT_FROM := pyproject.toml setup.py constraints.txt gtm_fmu/units.py gtm_fmu/errors.py \
	$(wildcard gtm_fmu/airframe/*.py gtm_fmu/airframe/data/*) \
	$(wildcard $(addprefix gtm_fmu/core/,*.c *.h gtm/*.[ch] solver/*.[ch] generate*.py c_source.py stored_tables.py sources.py)) surrogate/core/network.c

.PHONY: study test quick coverage docs publish-study benchmarks publish-benchmarks pythons wheels clean

study: .venv/installed
	$(BIN)/gtm-fmu study --output build/study

test: .venv/installed
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy --num-workers 2
	$(BIN)/pytest $(TWO_WORKERS)

# What has no slow nature: no compiled FMU, no training, no whole command.
quick: .venv/installed
	$(BIN)/pytest $(TWO_WORKERS) -m "not slow"

# Which lines the tests reach, those that run in other processes included; fails below the floor in pyproject.toml.
coverage: .venv/installed
	$(BIN)/coverage erase
	$(BIN)/coverage run -m pytest $(TWO_WORKERS)
	$(BIN)/coverage combine --quiet
	$(BIN)/coverage report

# The documentation as a site in build/site; open build/site/index.html, no server and no network needed.
docs: .venv/installed
	$(BIN)/mkdocs build --strict --quiet

# What README and docs show of the study: results and pictures of the last `make study`.
publish-study: .venv/installed
	$(BIN)/python docs/site/paper.py build/study

benchmarks: .venv/installed
	for script in $(filter-out benchmarks/table.py benchmarks/compare.py,$(wildcard benchmarks/*.py)); do \
		$(BIN)/python $$script || exit 1; done
	$(BIN)/python benchmarks/compare.py build/benchmarks benchmarks/results

# What README quotes: the results of the last `make benchmarks` on an idle machine.
publish-benchmarks:
	cp build/benchmarks/*.json benchmarks/results/

# The quick tests on other Pythons that are here, and with the oldest libraries that are allowed; needs uv. Without torch:
# not every Python has one that is small.
PYTHONS ?= 3.12 3.13 3.14
WITHOUT_TORCH := build/pythons/without_torch.txt
pythons: .venv/installed
	@mkdir -p build/pythons; echo "torch; python_version < '3'" > $(WITHOUT_TORCH)
	@for name in lowest $(PYTHONS); do \
		python=$$name; resolution=highest; \
		if [ $$name = lowest ]; then python=3.11; resolution=lowest-direct; fi; \
		venv=build/pythons/$$name; \
		uv venv --quiet --clear --no-python-downloads --python $$python $$venv || { echo "no Python $$python here"; continue; }; \
		uv pip install --quiet --compile-bytecode --python $$venv/bin/python --resolution $$resolution \
			--overrides $(WITHOUT_TORCH) '.[study,train,test]' || exit 1; \
		$$venv/bin/python -m pytest -q $(TWO_WORKERS) -m "not slow" || exit 1; \
	done

# The source archive and a wheel for each platform.
wheels: .venv/installed
	$(BIN)/python build_wheels.py dist

.venv/installed: $(BUILT_FROM)
	$(PYTHON) -m venv .venv
	$(INSTALL) setuptools wheel casadi lazy-loader numpy
	$(INSTALL) --no-build-isolation --editable '.[study,train,test,docs]'
	touch $@

clean:
	rm -rf .venv build dist *.egg-info gtm_fmu/core/generated gtm_fmu/core/gtm_core.so surrogate/core/network.so
