MESH_TEST_SOURCES := $(filter-out tests/core/mesh/bandwidth_test.cc,$(wildcard tests/core/mesh/*.cc))
$(eval $(call unit_test,mesh_test,$(MESH_TEST_SOURCES),$O/libcore.a,))

# The test runs a program that is beside it in the build tree.
BANDWIDTH_TEST_SOURCES := tests/core/mesh/bandwidth_test.cc tests/tools/run.cc tests/control/server.cc
$(eval $(call unit_test,bandwidth_test,$(BANDWIDTH_TEST_SOURCES),$O/libcontrol.a $O/libcore.a,))
$O/tests/bandwidth_test: | $O/mlccactl
