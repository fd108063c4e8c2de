# The tests run the program as a user does.
$(eval $(call unit_test,analyse_bus_test,$(wildcard tests/tools/design/analyse_bus/*.cc) tests/tools/design/check/program.cc,,-lutil))
$(patsubst %.cc,$O/%.o,$(wildcard tests/tools/design/analyse_bus/*.cc)): CPPFLAGS += $(TOOLS_CPPFLAGS)
$O/tests/analyse_bus_test: | $O/mlccactl $O/mlcca-design
