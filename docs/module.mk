# Installs the pages below share/doc/mlcca, beside examples/, and what else they link to, so that the
# links work there (tests/docs/installed).
PAGES := README.md CHANGELOG.md $(wildcard docs/*.md docs/*/*.md docs/drawings/*.svg docs/reference/bench/*) \
	proto/mlcca/v1/control.proto include/mlcca/client/events.h
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
