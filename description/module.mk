# The schema is compiled into the program, so that a daemon never depends on a file next to it.
XML_CFLAGS := $(shell $(PKG_CONFIG) --cflags libxml-2.0 2>/dev/null | sed 's/-I/-isystem /g')
XML_LIBS := $(shell $(PKG_CONFIG) --libs libxml-2.0 2>/dev/null)
$(eval $(call library,description,$(wildcard description/*.cc)))
$(description_objects): CPPFLAGS += $(XML_CFLAGS)

# As one raw string literal, which compiler and clang-tidy read alike.
$O/made/system_xsd.inc: description/system.xsd
	$(call say,XSD,$@)
	$(Q)mkdir -p $(@D) && { printf 'R"xsd('; cat $<; printf ')xsd"\n'; } > $@

# The recogniser's table.
$O/made/grammar_table.inc: description/make-grammar description/system.xsd
	$(call say,GRAMMAR,$@)
	$(Q)mkdir -p $(@D) && description/make-grammar description/system.xsd > $@
DESCRIPTION_TABLES := $O/made/system_xsd.inc $O/made/grammar_table.inc
$(description_objects) $O/description/schema.o $O/description/grammar.o: | $(DESCRIPTION_TABLES)

# The format as one page, and the check in XSLT for tool chains that have nothing but XML.
$O/reference.html: description/reference.xsl description/system.xsd \
		$(wildcard examples/*/*.xml examples/*/*/*.xml)
	$(call say,XSLT,$@)
	$(Q)mkdir -p $(@D) && xsltproc --nonet -o $@ description/reference.xsl description/system.xsd
reference: $O/reference.html ## the reference of the description format, as HTML

FORMAT_FILES := $(addprefix description/,system.xsd check.xsl check-values.xsl check-report.xsl check-sense.xsl)
install-format: $O/reference.html
	$(call say,INSTALL,schema and XSLT check and reference of the description format)
	$(Q)install -d $(DESTDIR)$(PREFIX)/share/mlcca $(DESTDIR)$(PREFIX)/share/doc/mlcca
	$(Q)install -m 644 $(FORMAT_FILES) $(DESTDIR)$(PREFIX)/share/mlcca
	$(Q)install -m 644 $O/reference.html $(DESTDIR)$(PREFIX)/share/doc/mlcca/reference.html
INSTALL += install-format
.PHONY: reference install-format
