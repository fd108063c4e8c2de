# SPDX-License-Identifier: BSD-2-Clause
$(eval $(call unit_test,readback_test,tests/readback/probes_test.cc daemon/readback/probes.cc,,-lfmt))
