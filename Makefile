# Targets are real files with real dependencies: an unchanged step is not run again.
# the first Python that the package allows; asked for only where the virtual environment is made
PYTHON ?= $(firstword $(foreach p,python3.11 python3.12 python3.13 python3 python,$(shell $(p) -c \
	'import sys; (3, 11) <= sys.version_info[:2] < (3, 14) and print("$(p)")' 2>/dev/null)))
VENV := .venv
BIN := $(VENV)/bin
STAMP := $(VENV)/.installed
OUT := build
SEED := 1
SOURCES := $(shell find sstl_cli -type f -not -name '*.pyc' -not -path '*/__pycache__/*')

.DEFAULT_GOAL := help
.PHONY: help install test suite tests compiled rigs test-slow coverage lint docs reproduce reproduce-seeds withheld beyond blind blind-full library learn bench sbom house statistics fuzz kill mutation likelihood real effects-table gate-table samples limit-table next-table clean
.DELETE_ON_ERROR:

help: ## show this help
	@awk -F ':.*## ' '/^[a-z][a-z-]*:.*## /{printf "  make %-14s %s\n", $$1, $$2}' $(MAKEFILE_LIST)

install: $(STAMP) ## make the virtual environment with pinned packages (torch: CPU)

$(STAMP): pyproject.toml constraints.txt
	@test -x $(BIN)/python || test -n "$(PYTHON)" || { echo "no Python 3.11, 3.12 or 3.13 found: install one, or give make PYTHON=/path/to/python" >&2; exit 1; }
	test -x $(BIN)/python || $(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --no-compile --disable-pip-version-check -c constraints.txt torch==2.13.0
	$(BIN)/python -m pip install --quiet --no-compile --disable-pip-version-check -c constraints.txt -e '.[robot,onnx,cluster,bench,dev]'
# on all cores: pip compiles one module after the other; some packages bring files that are no Python, and much that is never loaded
	$(BIN)/python -m compileall -qq -j 0 -x '/(tests?|plotly|sympy|networkx|OpenGL|pip|setuptools|devtools)/' $(VENV)/lib sstl_cli || true
	touch $@

test: $(STAMP) ## run linters, type check, layer check and the tests
	$(MAKE) --no-print-directory -j2 lint suite

# machine code once, beside the type check: each worker of the suite would make it for itself; of the diagnosis, then of the rigs
compiled: $(STAMP)
	$(BIN)/sstl diagnose data/samples/log.parquet --workers 1 --quiet --force --out $(VENV)/compiled.json >/dev/null

rigs: $(STAMP)
	$(BIN)/sstl blind make $(VENV)/rigs --cases 3 --quick --workers 1 --seed 1 --quiet --force

# beside what is left of the type check: one core would wait for it
suite: compiled rigs
	$(MAKE) --no-print-directory tests

tests: $(STAMP)
	$(BIN)/python -m pytest -n 2 --dist loadfile --no-loadscope-reorder -m 'not slow'

test-slow: $(STAMP) ## run the tests that take minutes
	$(BIN)/python -m pytest -m slow --timeout 3600

# tests of how long something takes may fail while it is measured
coverage: $(STAMP) ## lines and branches that the tests run, part by part (half an hour; compiled functions are not seen)
	-$(BIN)/python -m coverage run -m pytest -n 2 --dist loadfile --no-loadscope-reorder -m 'not slow'
	$(BIN)/python -m coverage combine --quiet
	$(BIN)/python tools/coverage_table.py

lint: $(STAMP) ## ruff, mypy, import-linter, and what no line uses
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports
	$(BIN)/python tools/dead_code.py

docs: $(STAMP) ## the site of the documents in build/site; a broken link is an error
	$(BIN)/python tools/reference_doc.py --check
	$(BIN)/python tools/site.py

reproduce: $(OUT)/reproduce/.done ## rebuild the paper's tables beside the published values; fails outside the committed spread
	@cat $(OUT)/reproduce/tables.txt

$(OUT)/reproduce/.done: $(STAMP) $(SOURCES)
	mkdir -p $(OUT)/reproduce
	$(BIN)/sstl reproduce --out $(OUT)/reproduce --seed $(SEED) --force > $(OUT)/reproduce/tables.tmp
	mv $(OUT)/reproduce/tables.tmp $(OUT)/reproduce/tables.txt
	touch $@

reproduce-seeds: $(STAMP) ## every table over many data sets: the spread that `make reproduce` is held against (an hour)
	mkdir -p $(OUT)/seeds
	nice -n 15 $(BIN)/sstl reproduce --spread --spread-seeds 50 --seed 0 --out $(OUT)/seeds --force
	nice -n 15 $(BIN)/sstl reproduce --spread --table R --spread-seeds 20 --seed 100 --out $(OUT)/seeds --force
	nice -n 15 $(BIN)/sstl reproduce --spread --table III --spread-seeds 30 --seed 100 --out $(OUT)/seeds --force
	cp $(OUT)/seeds/spread*.csv sstl_cli/paper/

withheld: $(STAMP) ## each effect of the rig withheld from a simulator in turn, diagnosed and put back (ten minutes)
	mkdir -p $(OUT)/withheld
	nice -n 15 $(BIN)/sstl reproduce --table withheld --seed $(SEED) --out $(OUT)/withheld --force

beyond: $(STAMP) ## what the paper leaves to future work, on the rig; writes docs/beyond.txt (five minutes)
	mkdir -p $(OUT)/beyond
	nice -n 15 $(BIN)/sstl reproduce --table better,probe,tendons,distal --seed 1 --out $(OUT)/beyond --force > $(OUT)/beyond/tables.txt
	sed '/ files -> /d' $(OUT)/beyond/tables.txt > docs/beyond.txt

blind: $(OUT)/blind-quick/score.json ## withheld-effect check, quick subset (about two minutes)

$(OUT)/blind-quick/score.json: $(STAMP) $(SOURCES)
	rm -rf $(OUT)/blind-quick && mkdir -p $(OUT)
	$(BIN)/sstl blind make $(OUT)/blind-quick --quick --seed $(SEED)
	$(BIN)/sstl blind run $(OUT)/blind-quick
	$(BIN)/sstl blind score $(OUT)/blind-quick --out $@

# as the published set was made
PUBLISHED := --cases 540 --nulls 370 --quick --simulator mixed
blind-full: $(STAMP) ## withheld-effect check, published run (hours); the seed is drawn and sealed
	mkdir -p $(OUT)
	test -d $(OUT)/blind-full || $(BIN)/sstl blind make $(OUT)/blind-full $(PUBLISHED)
	$(BIN)/sstl blind run $(OUT)/blind-full
	$(BIN)/sstl blind limit $(OUT)/blind-full
	$(BIN)/sstl blind score $(OUT)/blind-full --out $(OUT)/blind-full/score.json --force
	$(BIN)/python tools/blind_table.py $(OUT)/blind-full/score.json --commit "$$(git rev-parse --short HEAD)" --set="$(PUBLISHED)"

library: $(STAMP) ## draw and search the cases that the verdict is learned from (hours; goes on where it stopped)
	mkdir -p $(OUT)
	test -f $(OUT)/library.parquet || nice -n 10 $(BIN)/sstl blind library $(OUT)/library.parquet --cases 600 --quick --seed 44000000
	test -f $(OUT)/library-large.parquet || nice -n 10 $(BIN)/sstl blind library $(OUT)/library-large.parquet --cases 200 --quick --seed 44100000 --strength 12 --strength 40
	test -f $(OUT)/library-habits.parquet || nice -n 10 $(BIN)/sstl blind library $(OUT)/library-habits.parquet --cases 360 --quick --habits --seed 44300000 --strength 1.2 --strength 4 --strength 12 --strength 40
	test -f $(OUT)/library-accepted.parquet || nice -n 10 $(BIN)/sstl blind library $(OUT)/library-accepted.parquet --cases 180 --quick --accepted --seed 45200000 --strength 2 --strength 6 --strength 20 --strength 60

LIBRARY := $(sort $(wildcard data/library-*.parquet))
learn: $(STAMP) ## learn the verdict's weights again from LIBRARY, say how they do on simulators left out
	mkdir -p $(OUT)
	$(BIN)/sstl blind learn $(LIBRARY) --out sstl_cli/diagnosis/weights.json --force --json > $(OUT)/learn.json
	$(BIN)/python tools/learned_table.py $(OUT)/learn.json

bench: $(STAMP) ## compare with what a user would do instead; writes benchmarks/results.json
	$(BIN)/python benchmarks/run.py

sbom: $(STAMP) ## licences, sizes, bill of materials and pip check; writes docs/supply.md
	$(BIN)/python tools/supply_chain.py

house: $(STAMP) ## lines by layer, and what is not typed, long or ignored, then and now (CONTRIBUTING.md)
	$(BIN)/python tools/house.py 3a4b0a8

statistics: $(STAMP) ## coverage of every printed interval; writes docs/statistics.md
	$(BIN)/python tools/statistics_table.py

fuzz: $(STAMP) ## damaged files for every reader (COUNT a kind, at most MINUTES in all); fills docs/trust.md
	$(BIN)/python tools/fuzz.py --count $(or $(COUNT),100000) --minutes $(or $(MINUTES),15) --publish

kill: $(STAMP) ## kill -9 at 200 random moments; fills docs/trust.md
	$(BIN)/python tests/trust/kill_writers.py $(or $(COUNT),200) --publish

mutation: $(STAMP) ## do the tests notice small faults? a sample of SAMPLE a part; fills docs/trust.md
	$(BIN)/python tools/mutation.py --sample $(or $(SAMPLE),100) --seed $(SEED) --publish

likelihood: $(STAMP) ## whitened residuals of nulls by simulator and phase; writes docs/likelihood.md
	$(BIN)/python tools/likelihood.py

real: $(STAMP) ## recordings made by others (../shared/data): own record, untouched half, effects put in; writes docs/real.md
	mkdir -p $(OUT)/real
	$(BIN)/python tools/real_table.py --out $(OUT)/real

effects-table: $(STAMP) ## fast model against rig and bristle simulator, per effect; writes docs/effects.md, bristle.md and variant.md
	$(BIN)/python tools/effects_table.py
	$(BIN)/python tools/effects_table.py --simulator bristle
	$(BIN)/python tools/variant_table.py

limit-table: $(STAMP) ## what recordings could tell, and simulated error rates (docs/limit.md; minutes, resumable)
	nice -n 10 $(BIN)/python tools/limit_simulation.py --draws 100
	nice -n 10 $(BIN)/python tools/limit_table.py

next-table: $(STAMP) ## does recording what is proposed settle the question? (docs/limit.md; ten minutes a run, resumable)
	nice -n 10 $(BIN)/python tools/next_table.py

gate-table: $(STAMP) ## wrong and sound recordings judged by the physics gate; fills docs/gate.md
	$(BIN)/python tools/gate_table.py --seed $(SEED) --publish

samples: data/samples/log.parquet data/samples/bench/bend20_slow_act.csv ## remake the sample recordings

data/samples/log.parquet: sstl_cli/physics/scenarios/sample.toml | $(STAMP)
	cd data/samples && ../../$(BIN)/sstl simulate --scenario sample --simulator rig --effect pulley_friction:m_p=0.08,m_r=0.06 --seed 7 --out log.parquet --force

data/samples/bench/bend20_slow_act.csv: data/samples/bench.toml tools/bench_files.py | $(STAMP)
	mkdir -p $(OUT)
	$(BIN)/sstl simulate --scenario data/samples/bench.toml --seed 3 --out $(OUT)/bench.parquet --force
	$(BIN)/python tools/bench_files.py $(OUT)/bench.parquet data/samples/bench

clean: ## remove everything that was built
	rm -rf $(OUT)
