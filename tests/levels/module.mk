# Random systems must have the same result at every level: check, the daemon, generated code, the
# stylesheets.
LEVELS_TEST_SOURCES := $(wildcard tests/levels/*.cc) tests/description/twin/twin.cc $(addprefix tests/description/twin/,forms.cc random_values.cc) tests/tools/design/check/program.cc
$(eval $(call unit_test,levels_test,$(LEVELS_TEST_SOURCES),$(DESIGN_ARCHIVES),$(DESIGN_LIBS) -lutil))
$(patsubst %.cc,$O/%.o,$(wildcard tests/levels/*.cc)): CPPFLAGS += $(TOOLS_CPPFLAGS)
# The tests run a program of this build tree.
$O/tests/levels_test: | $O/mlccactl $O/mlcca-design
