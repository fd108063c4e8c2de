# The protocol of a cluster, and a checker that explores CLUSTER_STATES states of each scenario.
$(eval $(call unit_test,cluster_member_test,$(wildcard tests/core/cluster/*.cc),$O/libcore.a,))
CLUSTER_STATES ?= 20000000
soak-cluster: $O/tests/cluster_member_test
	$(Q)CLUSTER_STATES=$(CLUSTER_STATES) $< --gtest_filter='ClusterChecker.*'
.PHONY: soak-cluster
