# The fake daemon and its messages are shared with the control tests.
TOOLS_TEST_SOURCES := $(wildcard tests/tools/*.cc) tests/control/server.cc tests/control/messages.cc tests/control/cluster.cc tests/control/transfers.cc tests/control/requests.cc
$(eval $(call unit_test,tools_test,$(TOOLS_TEST_SOURCES),$(TOOLS_ARCHIVES),))
# The test runs programs that are beside it in the build tree.
$O/tests/tools_test: | $O/mlccactl $O/mlcca-design $O/mlcca-doctor $O/mlcca-readback
