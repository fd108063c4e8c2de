# SPDX-License-Identifier: BSD-2-Clause
$(eval $(call unit_test,relay_test,$(filter-out %_live_test.cc,$(wildcard tests/relay/*.cc tests/relay/famouso/*.cc)) tests/control/server.cc,$O/librelay.a $O/libclient.a $O/librelay.a $O/libcontrol.a,-lfmt))
# Tests named *_live_test.cc need root and a namespace of their own.
$(eval $(call kernel_test,relay_live_test,$(wildcard tests/relay/*_live_test.cc),$O/librelay.a $O/libcontrol.a,-lfmt))
