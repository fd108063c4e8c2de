# The tests run the program as a user does.
$(eval $(call unit_test,new_test,$(wildcard tests/tools/design/new/*.cc) tests/tools/design/describe/program.cc,,-lutil))
$(patsubst %.cc,$O/%.o,$(wildcard tests/tools/design/new/*.cc)): CPPFLAGS += $(TOOLS_CPPFLAGS)
$O/tests/new_test: | $O/mlccactl $O/mlcca-design
