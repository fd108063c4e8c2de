# SPDX-License-Identifier: BSD-2-Clause
$(eval $(call unit_test,readback_test,$(wildcard tests/readback/*_test.cc) $(addprefix daemon/readback/,differences.cc probes.cc ether_probes.cc),$O/libenforce.a $O/libcore.a,-lbpf -lfmt))
