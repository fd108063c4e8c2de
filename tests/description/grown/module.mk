# A recogniser generated from a schema that has more than system.xsd, from the same C++ code. The
# include path of its table comes first.
GROWN := $O/gen/grown
$(GROWN)/system.xsd: tests/description/grown/grow.xsl description/system.xsd
	$(call say,XSLT,$@)
	$(Q)mkdir -p $(@D) && xsltproc --nonet -o $@ $^
$(GROWN)/grammar_table.inc: description/make-grammar $(GROWN)/system.xsd
	$(call say,GRAMMAR,$@)
	$(Q)description/make-grammar $(GROWN)/system.xsd > $@
$O/tests/description/grown/grammar.o: description/grammar.cc $(GROWN)/grammar_table.inc
	$(call say,CXX,$<)
	$(Q)mkdir -p $(@D) && $(CXX) $(STD) $(WARN) -I$(GROWN) $(CPPFLAGS) $(CXXFLAGS) -MMD -MP -c $< -o $@
OBJECTS += $O/tests/description/grown/grammar.o
$(eval $(call unit_test,grown_test,$(wildcard tests/description/grown/*.cc),$O/tests/description/grown/grammar.o $O/libdescription.a $O/libcore.a,$(XML_LIBS) -lfmt))
