# The tests run the program as a user does. They find the corpus below the source root, where they
# are run.
$(eval $(call unit_test,check_test,$(wildcard tests/tools/design/check/*.cc),$(DESIGN_ARCHIVES),$(DESIGN_LIBS) -lutil))
$(patsubst %.cc,$O/%.o,$(wildcard tests/tools/design/check/*.cc)): CPPFLAGS += $(TOOLS_CPPFLAGS)
$O/tests/check_test: | $O/mlccactl $O/mlcca-design
