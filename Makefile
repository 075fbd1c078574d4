PYTHON ?= python3
BIN := .venv/bin

.PHONY: check-cad help venv demo check test bench bench-parts bench-parts-quick table-one docs pictures example clean

help:  ## show the targets
	@grep -E '^[a-z-]+:.*##' $(MAKEFILE_LIST) | sed 's/:.*## /\t/'

.venv/installed: pyproject.toml
	$(PYTHON) -m venv .venv
	$(BIN)/python -m pip install --quiet --editable '.[dev]'
	@touch $@

venv: .venv/installed  ## make .venv with the package and the tools

demo: venv  ## reconstruct the bundled scan to out/bracket.step
	@mkdir -p out
	$(BIN)/crispline reconstruct examples/bracket.ply -o out/bracket.step --summary out/bracket.json

check: venv  ## style, types, import directions
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports

test: check  ## the checks, then the tests
	$(BIN)/pytest -n 2

bench: venv  ## accuracy on the paper's model, speed of curvature and detection
	OMP_NUM_THREADS=1 $(BIN)/python benchmarks/curvature.py
	$(BIN)/python benchmarks/box_cylinder.py

bench-parts: venv  ## whole program over modelled parts (and truths in CRISPLINE_TRUTH); hours
	$(BIN)/python benchmarks/parts_table.py --markdown docs/parts-table.md

bench-parts-quick: venv  ## the same at 12,000 points and one noise level
	$(BIN)/python benchmarks/parts_table.py --points 12000 --noise 0.001

check-cad: venv  ## whether FreeCAD, gmsh and openNURBS, where installed, read the solids
	$(BIN)/python benchmarks/check_cad.py

table-one: venv  ## the paper's experiment: table and rows in out/
	@mkdir -p out
	$(BIN)/crispline paper --json out/table-one.json --markdown out/table-one.md

docs: venv  ## the documentation as pages in site/
	$(BIN)/python -m pip install --quiet --editable '.[docs]'
	rm -rf site
	$(BIN)/sphinx-build -W --keep-going -q -E -d .doctrees docs site
	@rm -rf .doctrees
	@echo site/index.html

pictures: venv  ## draw the pictures of the documentation anew
	$(BIN)/python -m pip install --quiet --editable '.[docs]'
	$(BIN)/python docs/pictures.py
	$(BIN)/python docs/paper_figures.py

example: venv  ## make the bundled scan anew
	$(BIN)/crispline sample bracket --points 40000 --noise 0.01 --outliers 0.005 --seed 1 -o examples/bracket.ply

clean:  ## remove everything that is made
	rm -rf .venv out site build dist .mypy_cache .pytest_cache .ruff_cache .import_linter_cache
