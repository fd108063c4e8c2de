# SPDX-License-Identifier: BSD-2-Clause
$(eval $(call unit_test,include_test,$(wildcard tests/include/*.cc)))
