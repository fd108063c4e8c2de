#The corpus and the examples are found below the source root, where tests are run.
$(eval $(call unit_test,description_test,$(wildcard tests/description/*.cc),$O/libdescription.a $O/libcore.a,$(XML_LIBS) -lfmt))
$(patsubst %.cc,$O/%.o,$(wildcard tests/description/*.cc)): CPPFLAGS += $(XML_CFLAGS)
