# SPDX-License-Identifier: BSD-2-Clause
$(eval $(call unit_test,readback_test,$(wildcard tests/readback/*_test.cc) daemon/readback/probes.cc daemon/readback/ether_probes.cc,$O/libcore.a,-lfmt))
