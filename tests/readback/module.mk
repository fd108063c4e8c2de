# SPDX-License-Identifier: BSD-2-Clause
$(eval $(call unit_test,readback_test,$(addprefix tests/readback/,differences_test.cc probes_test.cc ether_probes_test.cc) $(addprefix daemon/readback/,differences.cc probes.cc ether_probes.cc),$O/libenforce.a $O/libcore.a,-lbpf -lfmt))
$(eval $(call kernel_test,replica_test,tests/readback/replica_test.cc tests/enforce/sandbox.cc $(filter-out daemon/readback/main.cc,$(wildcard daemon/readback/*.cc)),$(DAEMON_ARCHIVES),$(DAEMON_LIBS)))
