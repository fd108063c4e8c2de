#The way to the store.Tests named* _live_test.cc take the etcd of the distribution.
CLUSTER_HELPERS := $(addprefix tests/cluster/,gateway.cc processes.cc)
$(eval $(call unit_test,cluster_test,$(filter-out %_live_test.cc %/daemons_test.cc,$(wildcard tests/cluster/*_test.cc)) $(CLUSTER_HELPERS),$(CLUSTER_ARCHIVES) $O/libclustercodec.a $O/libcontrol.a $O/libcore.a,$(CLUSTER_LIBS)))
$(eval $(call unit_test,cluster_live_test,$(wildcard tests/cluster/*_live_test.cc) $(CLUSTER_HELPERS) $(addprefix tests/cluster/,store.cc tunnel.cc),$(CLUSTER_ARCHIVES),$(CLUSTER_LIBS)))
$O/tests/cluster_live_test: | $O/mlcca-cluster
# Two mlccad, with gates in the kernel.
$(eval $(call kernel_test,cluster_daemons_test,$(addprefix tests/cluster/,daemons_test.cc processes.cc store.cc),,))
$O/tests/cluster_daemons_test: | $O/mlccad $O/mlccactl $O/mlcca-design $O/mlcca-cluster
