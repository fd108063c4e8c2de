# Installs the pages below share/doc/mlcca, beside examples/, so that the links between them work.
PAGES := README.md CHANGELOG.md $(wildcard docs/*.md docs/*/*.md docs/drawings/*.svg docs/reference/bench/*)
install-docs:
	$(call say,INSTALL,$(words $(PAGES)) pages)
	$(Q)for file in $(PAGES); do \
		install -D -m 644 $$file $(DESTDIR)$(PREFIX)/share/doc/mlcca/$$file || exit 1; \
	done
PARTS += install-docs

DRAWINGS := $(wildcard docs/drawings/*.txt)
drawings: $(DRAWINGS:.txt=.svg) ## the drawings of the documentation, from their sources
docs/drawings/%.svg: docs/drawings/%.txt docs/drawings/draw
	$(call say,DRAW,$@)
	$(Q)docs/drawings/draw $< > $@.new && mv $@.new $@
.PHONY: install-docs drawings
