$(eval $(call unit_test,learn_test,$(wildcard tests/tools/learn/*.cc) tests/tools/design/describe/program.cc,$(DESIGN_ARCHIVES),$(DESIGN_LIBS) -lutil))
$O/tests/learn_test: | $O/mlccactl $O/mlcca-design
