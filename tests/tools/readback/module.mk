# SPDX-License-Identifier: BSD-2-Clause
$(eval $(call unit_test,readback_test,$(addprefix tests/tools/readback/,differences_test.cc probes_test.cc ether_probes_test.cc fate_test.cc) $(addprefix tools/readback/,differences.cc probes.cc ether_probes.cc),$O/daemon/store/records.o $O/libenforce.a $O/libcontrol.a $O/libcore.a,-lbpf -lfmt))
$(eval $(call kernel_test,replica_test,tests/tools/readback/replica_test.cc tests/daemon/gates/sandbox.cc $(filter-out tools/readback/main.cc,$(wildcard tools/readback/*.cc)),$(DAEMON_ARCHIVES),$(DAEMON_LIBS)))
