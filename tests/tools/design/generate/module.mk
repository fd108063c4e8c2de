GENERATE_TEST_SOURCES := $(wildcard tests/tools/design/generate/*.cc) tests/tools/design/describe/program.cc
$(eval $(call unit_test,generate_test,$(GENERATE_TEST_SOURCES),$(DESIGN_ARCHIVES),$(DESIGN_LIBS) -lfmt -lutil))
$(patsubst %.cc,$O/%.o,$(wildcard tests/tools/design/generate/*.cc)): CPPFLAGS += $(TOOLS_CPPFLAGS)
# The tests run a program of this build tree.
$O/tests/generate_test: | $O/mlcca-design $O/mlccactl
