# Tests find the corpus and the examples below the source root, where they are run.
$(eval $(call unit_test,description_test,$(wildcard tests/description/*.cc),$O/libdescription.a $O/libcore.a,$(XML_LIBS) -lfmt))
$(patsubst %.cc,$O/%.o,$(wildcard tests/description/*.cc)): CPPFLAGS += $(XML_CFLAGS)
