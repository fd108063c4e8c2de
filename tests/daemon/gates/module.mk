$(eval $(call unit_test,slots_test,$(addprefix tests/daemon/gates/,slots_test.cc slot_limits_test.cc slot_traffic_test.cc slot_record_test.cc),$O/libenforce.a,-lbpf -lfmt))
$(eval $(call kernel_test,attach_test,$(addprefix tests/daemon/gates/,attach_test.cc restart_test.cc tcx_test.cc readback_test.cc watch_test.cc control_test.cc deadman_test.cc orphan_test.cc starting_test.cc sandbox.cc),$O/libenforce.a,-lbpf -lfmt))
$(eval $(call unit_test,ether_table_test,$(addprefix tests/daemon/gates/,ether_table_test.cc ether_watches_test.cc),$O/libenforce.a,-lbpf -lfmt))
