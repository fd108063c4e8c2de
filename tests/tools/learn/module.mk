# Tests named *_live_test.cc need root and their own namespace.
$(eval $(call unit_test,learn_test,$(filter-out %_live_test.cc,$(wildcard tests/tools/learn/*.cc)) tests/tools/design/describe/program.cc,$(DESIGN_ARCHIVES),$(DESIGN_LIBS) -lutil))
$(eval $(call kernel_test,learn_live_test,tests/tools/learn/listen_live_test.cc tests/tools/learn/traffic.cc tests/tools/design/describe/program.cc,$O/liblearn.a $O/librelay.a $O/libtools.a $O/libcontrol.a $O/libcore.a,-lz -lutil))
$O/tests/learn_test $O/tests/learn_live_test: | $O/mlccactl $O/mlcca-design
