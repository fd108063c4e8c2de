# SPDX-License-Identifier: BSD-2-Clause
# What holds for the streams and the command line of each program.
$(eval $(call unit_test,programs_test,$(wildcard tests/tools/programs/*.cc) tests/control/server.cc tests/control/messages.cc tests/control/cluster.cc tests/control/transfers.cc,$(TOOLS_ARCHIVES),))
$O/tests/failing_close.so: tests/tools/programs/failing_close.c
	$(call say,CC,$@)
	$(Q)mkdir -p $(@D) && $(CC) -std=gnu17 -O1 -fPIC -shared -Wall -Wextra $(WERROR) -o $@ $<
$O/tests/programs_test: | $(PROGRAMS) $O/tests/failing_close.so
