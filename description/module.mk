# The schema is compiled into the program, so that a daemon never depends on a file next to it.
XML_CFLAGS := $(shell $(PKG_CONFIG) --cflags libxml-2.0 2>/dev/null | sed 's/-I/-isystem /g')
XML_LIBS := $(shell $(PKG_CONFIG) --libs libxml-2.0 2>/dev/null)
$(eval $(call library,description,$(wildcard description/*.cc)))
$(description_objects): CPPFLAGS += $(XML_CFLAGS)

# As one raw string literal, which compiler and clang-tidy read alike.
$O/gen/system_xsd.inc: description/system.xsd
	$(call say,XSD,$@)
	$(Q)mkdir -p $(@D) && { printf 'R"xsd('; cat $<; printf ')xsd"\n'; } > $@
$O/description/schema.o: $O/gen/system_xsd.inc
