# The connection to the store. Tests named *_live_test.cc use the etcd of the distribution.
CLUSTER_HELPERS := $(addprefix tests/cluster/,gateway.cc processes.cc)
$(eval $(call unit_test,cluster_test,$(filter-out %_live_test.cc %/daemons_test.cc,$(wildcard tests/cluster/*_test.cc)) $(CLUSTER_HELPERS),$(CLUSTER_ARCHIVES) $O/libclustercodec.a $O/libcontrol.a $O/libcore.a,$(CLUSTER_LIBS)))
$(eval $(call unit_test,cluster_live_test,$(wildcard tests/cluster/*_live_test.cc) $(CLUSTER_HELPERS) $(addprefix tests/cluster/,store.cc tunnel.cc),$(CLUSTER_ARCHIVES),$(CLUSTER_LIBS)))
$O/tests/cluster_live_test: | $O/mlcca-cluster
# Two daemons mlccad, with gates in the kernel.
$(eval $(call kernel_test,cluster_daemons_test,$(addprefix tests/cluster/,daemons_test.cc processes.cc store.cc),,))
$O/tests/cluster_daemons_test: | $O/mlccad $O/mlccactl $O/mlcca-design $O/mlcca-cluster
# Real gateways and a real store under faults, observed from outside. CI runs a fixed sample
# (CI_SEED) of five minutes, which are mostly spent waiting.
FAULTS_READY := $O/mlccad $O/mlccactl $O/mlcca-design $O/mlcca-cluster
SECONDS ?= 300
CLUSTER_SECONDS ?= 3600
check-cluster: $(FAULTS_READY) ## gateways and their store under faults, SECONDS=300 from SEED= where given: root
	$(Q)BUILD=$(abspath $O) SEED=$(or $(SEED),$(CI_SEED)) SECONDS=$(SECONDS) GATEWAYS=$(GATEWAYS) tests/cluster/faults/run
soak-gateways: $(FAULTS_READY)
	$(Q)BUILD=$(abspath $O) SEED=$(SEED) SECONDS=$(CLUSTER_SECONDS) tests/cluster/faults/run
.PHONY: check-cluster soak-gateways
