$(eval $(call unit_test,slots_test,$(addprefix tests/enforce/,slots_test.cc slot_limits_test.cc slot_traffic_test.cc slot_record_test.cc),$O/libenforce.a,-lbpf -lfmt))
$(eval $(call kernel_test,attach_test,$(addprefix tests/enforce/,attach_test.cc restart_test.cc tcx_test.cc readback_test.cc watch_test.cc control_test.cc sandbox.cc),$O/libenforce.a,-lbpf -lfmt))
