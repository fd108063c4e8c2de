# SPDX-License-Identifier: BSD-2-Clause
$(eval $(call unit_test,relay_test,$(wildcard tests/relay/*.cc tests/relay/famouso/*.cc) tests/control/server.cc,$O/librelay.a $O/libclient.a $O/librelay.a $O/libcontrol.a,-lfmt))
