$(eval $(call kernel_test,start_test,tests/daemon/start/start_test.cc tests/daemon/start/daemon.cc tests/daemon/gates/sandbox.cc,$O/libenforce.a,-lbpf -lfmt))
$(eval $(call kernel_test,unlisted_test,tests/daemon/start/unlisted_test.cc tests/daemon/start/daemon.cc tests/daemon/gates/sandbox.cc tests/bpf/ether/packets.cc,$O/libenforce.a,-lbpf -lfmt))
$O/tests/unlisted_test: $O/mlccad $O/mlccactl
$(eval $(call kernel_test,health_reasons_test,tests/daemon/start/health_reasons_test.cc tests/daemon/start/daemon.cc tests/daemon/gates/sandbox.cc,$O/libenforce.a,-lbpf -lfmt))
$O/tests/health_reasons_test: $O/mlccad $O/mlccactl $O/mlcca-sources
$O/tests/nss/libnss_hang.so.2: tests/daemon/start/nss_hang.c
	$(call say,CC,$@)
	$(Q)mkdir -p $(@D) && $(CC) -std=gnu17 -O1 -fPIC -shared -Wall -Wextra $(WERROR) -o $@ $<
$O/tests/slow_disk.so: tests/daemon/start/slow_disk.c
	$(call say,CC,$@)
	$(Q)mkdir -p $(@D) && $(CC) -std=gnu17 -O1 -fPIC -shared -Wall -Wextra $(WERROR) -o $@ $<
$O/tests/start_test: $O/tests/slow_disk.so $O/mlccad $O/mlccactl $O/mlcca-awds $O/mlcca-sources $O/tests/nss/libnss_hang.so.2
$O/tests/failing_file.so: tests/daemon/start/failing_file.c
	$(call say,CC,$@)
	$(Q)mkdir -p $(@D) && $(CC) -std=gnu17 -O1 -fPIC -shared -Wall -Wextra $(WERROR) -o $@ $<
$(eval $(call kernel_test,start_fault_test,tests/daemon/start/fault_test.cc tests/daemon/start/daemon.cc tests/daemon/gates/sandbox.cc,$O/libenforce.a,-lbpf -lfmt))
$O/tests/failing_types.so: tests/daemon/start/failing_types.c
	$(call say,CC,$@)
	$(Q)mkdir -p $(@D) && $(CC) -std=gnu17 -O1 -fPIC -shared -Wall -Wextra $(WERROR) -o $@ $<
$O/tests/start_fault_test: $O/tests/failing_file.so $O/tests/failing_types.so $O/mlccad
