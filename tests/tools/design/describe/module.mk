$(eval $(call unit_test,describe_test,$(wildcard tests/tools/design/describe/*.cc),$(DESIGN_ARCHIVES),$(DESIGN_LIBS) -lutil))
$(patsubst %.cc,$O/%.o,$(wildcard tests/tools/design/describe/*.cc)): CPPFLAGS += $(TOOLS_CPPFLAGS)
# The tests run a program of this build tree.
$O/tests/describe_test: | $O/mlcca-design $O/mlccactl
