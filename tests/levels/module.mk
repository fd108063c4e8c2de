# Random systems at every level: check, the daemon's decision, generated code, the stylesheet twin.
LEVELS_TEST_SOURCES := $(wildcard tests/levels/*.cc) tests/description/twin/twin.cc $(addprefix tests/description/twin/,forms.cc random_values.cc) tests/tools/design/check/program.cc
$(eval $(call unit_test,levels_test,$(LEVELS_TEST_SOURCES),$(DESIGN_ARCHIVES),$(DESIGN_LIBS) -lutil))
$(patsubst %.cc,$O/%.o,$(wildcard tests/levels/*.cc)): CPPFLAGS += $(TOOLS_CPPFLAGS)
# They run the program of this build tree.
$O/tests/levels_test: | $O/mlccactl $O/mlcca-design
