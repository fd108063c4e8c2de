# SPDX-License-Identifier: BSD-2-Clause
$(eval $(call unit_test,relay_test,$(filter-out %_live_test.cc %long_run_test.cc %/handler_rest_test.cc,$(wildcard tests/relay/*.cc tests/relay/famouso/*.cc)) tests/control/server.cc,$O/librelay.a $O/libclient.a $O/librelay.a $O/libcontrol.a,-lfmt))
# An hour of traffic in fast-forward takes minutes with sanitizers, and seconds without.
$(eval $(call unit_test,relay_long_run_test,$(wildcard tests/relay/*long_run_test.cc) tests/relay/famouso/node_client.cc,$O/librelay.a $O/libclient.a $O/librelay.a $O/libcontrol.a,-lfmt))
# Without free descriptors UBSan cannot examine an object, and reports a wrong one. So these tests
# are a separate program, which runs without sanitizers.
$(eval $(call unit_test,handler_rest_test,tests/relay/famouso/handler_rest_test.cc,$O/librelay.a $O/libclient.a $O/librelay.a $O/libcontrol.a,-lfmt))
# Tests named *_live_test.cc need root and their own namespace.
$(eval $(call kernel_test,relay_live_test,$(wildcard tests/relay/*_live_test.cc),$O/librelay.a $O/libcontrol.a,-lfmt))
