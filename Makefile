# Two commands matter: `make report` writes reports/build/longwave.pdf, `make test` runs the tests.
PY := .venv/bin/python
STAMP := .venv/.longwave-installed
DOCS_STAMP := .venv/.longwave-docs-installed
WORKERS ?= 2

DEPENDS := pyproject.toml tools/bootstrap.sh tools/constraints.txt tools/apt.sh

.PHONY: report report-full latex bench docs test test-slow recheck lint format clean help

help:
	@echo "make report     derive, check, run the scenes, typeset: reports/build/longwave.pdf"
	@echo "make report-full  the same with the long scenes and the full studies"
	@echo "make latex      installs LaTeX with apt where that may be, as make report does"
	@echo "make bench      what accuracy costs, nothing running beside: reports/build/bench"
	@echo "make docs       the site: docs/build/index.html"
	@echo "make test       the default test suite (WORKERS=$(WORKERS) processes)"
	@echo "make test-slow  the tests marked slow"
	@echo "make recheck    PARI/GP, Maxima and Coq repeat the proofs (installed with apt where that may be)"
	@echo "make lint       ruff check, ruff format --check, mypy"
	@echo "make format     let ruff rewrite the files"
	@echo "make clean      remove report, site and the tools' caches; .venv stays"

# Reinstalls only when the dependencies or the bootstrap change.
$(STAMP): $(DEPENDS)
	@sh tools/bootstrap.sh $@

# The site needs no more than it says: make docs installs the tools of the site alone.
$(DOCS_STAMP): $(DEPENDS)
	@sh tools/bootstrap.sh $@ docs

# Without an engine the report's source is written.
latex: $(STAMP)
	-@sh tools/apt.sh 'command -v latexmk && command -v pdflatex' \
		$$($(PY) -c 'from longwave.reports.engine import APT_PACKAGES as a; print(*a)')

report: latex
	@$(PY) -m reports --force --output reports/build

# A scene that is judged dishonest fails the report, which tables it, and not the search.
ESTIMATES := reports/build/estimates.jsonl
report-full: latex
	@mkdir -p reports/build && rm -f $(ESTIMATES)
	-@$(PY) -m searches.estimates --count 240 --seed 3 --workers $(WORKERS) --output $(ESTIMATES)
	@$(PY) -m reports --force --full --estimates $(ESTIMATES) --output reports/build

bench: $(STAMP)
	@$(PY) benchmarks/studies.py --output reports/build/bench

docs: $(DOCS_STAMP)
	@$(PY) -m sphinx --quiet --fail-on-warning --keep-going --jobs $(WORKERS) docs docs/build
	@echo docs/build/index.html

test: $(STAMP)
	@$(PY) -m pytest -q -n $(WORKERS) --dist loadfile

test-slow: $(STAMP)
	@$(PY) -m pytest -q -m slow -n $(WORKERS) --dist loadfile

recheck: $(STAMP)
	@$(PY) -m verify recheck

lint: $(STAMP)
	@$(PY) -m ruff check .
	@$(PY) -m ruff format --check .
	@$(PY) -m mypy

format: $(STAMP)
	@$(PY) -m ruff check --fix .
	@$(PY) -m ruff format .

docs/rogue_wave.png docs/rogue_wave.gif: $(STAMP)
	@$(PY) docs/rogue_wave.py $@

clean:
	rm -rf reports/build docs/build docs/generated .pytest_cache .mypy_cache .ruff_cache .hypothesis
	find . -name __pycache__ -not -path './.venv/*' -prune -exec rm -rf {} +
