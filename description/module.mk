# The schema is compiled into the programs, so that a daemon never depends on a file beside it.
XML_CFLAGS := $(shell $(PKG_CONFIG) --cflags libxml-2.0 2>/dev/null | sed 's/-I/-isystem /g')
XML_LIBS := $(shell $(PKG_CONFIG) --libs libxml-2.0 2>/dev/null)
$(eval $(call library,description,$(wildcard description/*.cc)))
$(description_objects): CPPFLAGS += $(XML_CFLAGS)

# The schema as one raw string literal, which the compiler and clang-tidy read in the same way.
$O/made/system_xsd.inc: description/system.xsd
	$(call say,XSD,$@)
	$(Q)mkdir -p $(@D) && { printf 'R"xsd('; cat $<; printf ')xsd"\n'; } > $@

# The table of the recogniser.
$O/made/grammar_table.inc: description/make-grammar description/system.xsd
	$(call say,GRAMMAR,$@)
	$(Q)mkdir -p $(@D) && description/make-grammar description/system.xsd > $@
DESCRIPTION_TABLES := $O/made/system_xsd.inc $O/made/grammar_table.inc
$(description_objects) $O/description/schema.o $O/description/grammar.o: | $(DESCRIPTION_TABLES)

# The reference of the format as one HTML page.
$O/reference.html: description/reference.xsl description/system.xsd \
		$(wildcard examples/*/*.xml examples/*/*/*.xml)
	$(call say,XSLT,$@)
	$(Q)mkdir -p $(@D) && xsltproc --nonet -o $@ description/reference.xsl description/system.xsd
reference: $O/reference.html ## the reference of the description format, as HTML

# The same as the manual page mlcca-system(5).
$O/mlcca-system.5: docs/man/mlcca-system.5.in description/man.xsl description/reference.xsl description/system.xsd
	$(call say,XSLT,$@)
	$(Q)mkdir -p $(@D) && xsltproc --nonet description/man.xsl description/system.xsd | cat docs/man/mlcca-system.5.in - > $@
MADE_PAGES := $O/reference.html $O/mlcca-system.5

FORMAT_FILES := $(addprefix description/,system.xsd check.xsl check-values.xsl check-report.xsl check-sense.xsl)
install-format: $(MADE_PAGES)
	$(call say,INSTALL,schema and XSLT check and reference of the description format)
	$(Q)install -d $(addprefix $(DESTDIR)$(PREFIX)/share/,mlcca doc/mlcca man/man5)
	$(Q)install -m 644 $(FORMAT_FILES) $(DESTDIR)$(PREFIX)/share/mlcca
	$(Q)install -m 644 $O/reference.html $(DESTDIR)$(PREFIX)/share/doc/mlcca/reference.html
	$(Q)install -m 644 $O/mlcca-system.5 $(DESTDIR)$(PREFIX)/share/man/man5/mlcca-system.5
PARTS += install-format
.PHONY: reference install-format
