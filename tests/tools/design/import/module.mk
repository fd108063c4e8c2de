# The tests run the program as a user does.
$(eval $(call unit_test,import_test,$(wildcard tests/tools/design/import/*.cc) tests/tools/design/describe/program.cc,,-lutil))
$(patsubst %.cc,$O/%.o,$(wildcard tests/tools/design/import/*.cc)): CPPFLAGS += $(TOOLS_CPPFLAGS)
$O/tests/import_test: | $O/mlccactl $O/mlcca-design
