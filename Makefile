# make demo, make test: everything else that is needed is made first. `make help` lists the rest.

PYTHON := .venv/bin/python
# Files of tests are run side by side, each in one process, on as many processors as there are, in the order of tests/conftest.py.
# A process takes up to 1.5 GB.
SIDE_BY_SIDE := -n logical --maxprocesses 8 --dist loadfile --no-loadscope-reorder
MATRIX := 4.2.23 4.5.15 5.0.1 5.2.3
# What the front door offers has types that checkers know, 100 % of it, and scripts of users have the types that they expect.
PYRIGHT := nice env PYTHONPATH=build/types .venv-lint/bin/pyright --pythonpath .venv-lint/bin/python
PUBLIC_TYPES := { nice .venv-lint/bin/mypy tests/package/typed_use.py && $(PYRIGHT) tests/package/typed_use.py && \
	$(PYRIGHT) --ignoreexternal --verifytypes haptic_tracing.core.run_time > build/pyright.txt || { cat build/pyright.txt; false; }; }
TYPES := nice .venv-lint/bin/mypy && $(PUBLIC_TYPES); types=$$?; .venv-lint/bin/python benchmarks/code_size.py --total; exit $$types
# mypy takes a minute where no earlier run has left a cache. It runs beside the tests, and what it says comes after them.
TESTS_AND_TYPES = @( $(TYPES) ) > build/types.txt 2>&1 & types=$$!; \
	$(PYTHON) -m pytest $(SIDE_BY_SIDE) -m "$(1)"; tests=$$?; \
	wait $$types; types=$$?; cat build/types.txt; [ $$tests = 0 ] && [ $$types = 0 ]

# Compiled modules are kept, whatever the environment says: the tests start Python some hundred times.
export PYTHONDONTWRITEBYTECODE :=

.PHONY: packages-for-demo packages-for-test help demo test test-quick test-heart test-more stress fuzz soak stability lint style format test-matrix $(MATRIX:%=test-%) test-gui test-vr test-godot docs validate package wheels bench samples clean
.DELETE_ON_ERROR:

help:
	@echo "make demo         the paper's first figure, played through Blender: picture, sound and haptic scene in out/"
	@echo "make test         linters, types and the whole suite"
	@echo "make test-quick   linters, types and the tests that are not marked slow"
	@echo "make test-heart   the suite in a copy without plugins/"
	@echo "make test-more    the long tests that one of their kind represents in the suite, and the property-based tests with 20 times the"
	@echo "                  examples, from random seeds"
	@echo "make stress       edits, undo, load, render and removed scenes in 20 random orders of 2,000, each result against a fresh trace"
	@echo "make fuzz         a million random inputs for all readers, formulas, stored properties and network messages"
	@echo "make soak         half an hour of live output on four made-up devices: lags, missed deadlines, memory, files and threads"
	@echo "make stability    scenes at the ends of what numbers can hold, against closed forms: a table and a plot"
	@echo "make lint         linters and types; make format mends what can be mended by itself"
	@echo "make test-matrix  the suite on bpy $(MATRIX)"
	@echo "make test-gui BLENDER=path/to/blender   the suite in Blender's own window"
	@echo "make test-vr REAL_BLENDER=path/to/tool  VR sessions against a simulated OpenXR runtime"
	@echo "make test-godot GODOT=path/to/godot     the add-on for Godot in Godot itself"
	@echo "make package      the extension, one zip per platform in dist/"
	@echo "make bench        measurements, printed as tables"
	@echo "make validate     the model beside published measurements: docs/validation.md"
	@echo "make docs         the documentation as web pages in out/docs"
	@echo "make samples      the sample scenes as .blend files in out/samples"
	@echo "make clean        remove everything made, the virtual environments included"

demo: packages-for-demo .venv/complete
	$(PYTHON) -m haptic_tracing demo --out out

test: packages-for-test .venv/complete wheels style
	$(call TESTS_AND_TYPES,not more)

test-quick: packages-for-test .venv/complete wheels style
	$(call TESTS_AND_TYPES,not slow)

test-heart: packages-for-test .venv/complete wheels
	packaging/without_plugins build/heart
	cd build/heart/haptic_tracing && ln -s ../../../wheels wheels && PYTHONPATH=$(CURDIR)/build/heart $(CURDIR)/$(PYTHON) -m pytest $(SIDE_BY_SIDE) -m "not more" --ignore tests/package

test-more: packages-for-test .venv/complete
	$(PYTHON) -m pytest $(SIDE_BY_SIDE) -m more
	$(PYTHON) -m pytest $(SIDE_BY_SIDE) -m hypothesis --times-examples 20

stress: packages-for-test .venv/complete
	$(PYTHON) -m pytest tests/addon/test_stress.py --stress-seeds 20 --stress-operations 2000

stability: packages-for-test .venv/complete
	$(PYTHON) -m benchmarks.stability

fuzz: .venv/complete
	$(PYTHON) tests/addon/fuzzing --inputs 1000000

soak: packages-for-test .venv/complete
	$(PYTHON) -m benchmarks.soak
	$(PYTHON) -m benchmarks.soak_failures

lint: style
	@$(TYPES)

style: .venv-lint/complete build/types/haptic_tracing
	.venv-lint/bin/ruff check .
	.venv-lint/bin/ruff format --check .

format: .venv-lint/complete
	.venv-lint/bin/ruff check --fix .
	.venv-lint/bin/ruff format .

test-matrix: $(MATRIX:%=test-%)

$(MATRIX:%=test-%): test-%: packages-for-test .venv-%/complete wheels
	.venv-$*/bin/python -m pytest $(SIDE_BY_SIDE) -m "not more"

test-gui: .venv/complete wheels
	@[ -n "$(BLENDER)$(REAL_BLENDER)" ] || { echo "haptic-tracing: say which Blender: make test-gui BLENDER=path/to/blender" >&2; exit 1; }
	BLENDER="$(BLENDER)" REAL_BLENDER="$(REAL_BLENDER)" $(PYTHON) -m pytest tests/gui

test-vr: .venv/complete wheels
	@[ -n "$(REAL_BLENDER)" ] || { echo "haptic-tracing: say how Blender is run with a runtime: make test-vr REAL_BLENDER=path/to/tool" >&2; exit 1; }
	REAL_BLENDER="$(REAL_BLENDER)" $(PYTHON) -m pytest tests/gui/test_in_vr.py

test-godot: .venv/complete
	@[ -n "$(GODOT)" ] || { echo "haptic-tracing: say which Godot: make test-godot GODOT=path/to/godot" >&2; exit 1; }
	GODOT="$(GODOT)" $(PYTHON) -m pytest tests/gui/test_in_godot.py

package: .venv/complete wheels
	$(PYTHON) packaging/build.py

wheels: .venv/complete
	@$(PYTHON) packaging/wheels.py

bench: .venv/complete
	@packaging/make_environment .venv newest test,benchmark
	$(PYTHON) benchmarks

validate: .venv/complete
	$(PYTHON) docs/write_validation_page.py

samples: packages-for-demo .venv/complete
	@mkdir -p out/samples
	@for name in $$($(PYTHON) -c "from haptic_tracing.sample_scenes import SAMPLES; print(*SAMPLES)"); do \
		$(PYTHON) -m haptic_tracing sample $$name --output out/samples/$$name.blend || exit 1; done

docs: .venv-docs/complete
	.venv-docs/bin/python docs/pictures/draw_layers.py
	.venv-docs/bin/python docs/write_schema_page.py
	.venv-docs/bin/python docs/write_command_pages.py
	.venv-docs/bin/python -m sphinx --quiet --fail-on-warning -b html docs out/docs
	@echo "wrote out/docs/index.html"

clean:
	rm -rf .venv .venv-* build dist out wheels *.egg-info .pytest_cache .mypy_cache .ruff_cache .hypothesis

.venv/complete: pyproject.toml packaging/constraints-3.11.txt packaging/constraints-3.13.txt
	@packaging/make_environment .venv

# The root folder is the package; the linters find it under its name by this link.
build/types/haptic_tracing:
	@mkdir -p build/types && ln -s ../.. $@

# Its own environment: types are checked against one NumPy, whichever the Blender at hand needs.
.venv-lint/complete: pyproject.toml packaging/constraints-3.11.txt packaging/constraints-3.13.txt
	@packaging/make_environment .venv-lint none lint

.venv-docs/complete: pyproject.toml packaging/constraints-3.11.txt packaging/constraints-3.13.txt
	@packaging/make_environment .venv-docs none docs

.venv-%/complete: pyproject.toml packaging/constraints-3.11.txt packaging/constraints-3.13.txt
	@packaging/make_environment .venv-$* $*

packages-for-demo packages-for-test: packages-for-%:
	@packaging/system_packages $*
