EXPORTER_TEST_SOURCES := $(wildcard tests/tools/exporter/*.cc) tests/control/server.cc tests/control/messages.cc tests/control/cluster.cc tests/control/transfers.cc
$(eval $(call unit_test,exporter_test,$(EXPORTER_TEST_SOURCES),$(EXPORTER_ARCHIVES),$(EXPORTER_LIBS) -lfmt))

check-exporter: $O/mlcca-exporter $O/mlccad $O/mlccactl ## a real Prometheus scrapes a real daemon (root)
	$(Q)tests/tools/exporter/run $O
.PHONY: check-exporter
