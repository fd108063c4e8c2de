# The tests run the program as a user does, and give its output to tshark, tc and cangw.
$(eval $(call unit_test,export_test,$(wildcard tests/tools/design/export/*.cc) tests/tools/design/describe/program.cc,,-lutil))
$(patsubst %.cc,$O/%.o,$(wildcard tests/tools/design/export/*.cc)): CPPFLAGS += $(TOOLS_CPPFLAGS)
$O/tests/export_test: | $O/mlccactl $O/mlcca-design
