FORMAT_TEST_SOURCES := $(wildcard tests/tools/design/format/*.cc) tests/tools/design/describe/program.cc \
	tests/levels/random_system.cc $(addprefix tests/description/twin/,forms.cc random_values.cc)
$(eval $(call unit_test,format_test,$(FORMAT_TEST_SOURCES),$(DESIGN_ARCHIVES),$(DESIGN_LIBS) -lutil))
$(patsubst %.cc,$O/%.o,$(wildcard tests/tools/design/format/*.cc)): CPPFLAGS += $(TOOLS_CPPFLAGS)
# The tests run a program of this build tree.
$O/tests/format_test: | $O/mlcca-design $O/mlccactl
