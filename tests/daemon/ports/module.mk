$(eval $(call unit_test,bypass_test,tests/daemon/ports/bypass_test.cc,$O/daemon/ports/bypass.o,))
# Tests of daemon/ports with gates that are plain values.
$(eval $(call unit_test,gate_set_test,$(addprefix tests/daemon/ports/,gate_set_test.cc vanished_gates_test.cc former_gates_test.cc),$(DAEMON_ARCHIVES),$(DAEMON_LIBS)))
$(eval $(call unit_test,gated_ports_test,$(addprefix tests/daemon/ports/,described_port_test.cc gate_report_test.cc interface_hold_test.cc gated_ports_test.cc delivery_frames_test.cc),$(DAEMON_ARCHIVES),$(DAEMON_LIBS)))
$(eval $(call kernel_test,drift_test,tests/daemon/ports/drift_test.cc tests/daemon/gates/sandbox.cc,$(DAEMON_ARCHIVES),$(DAEMON_LIBS)))
$(eval $(call kernel_test,vanish_test,tests/daemon/ports/vanish_test.cc tests/daemon/gates/sandbox.cc,$(DAEMON_ARCHIVES),$(DAEMON_LIBS) -ldl))
$(eval $(call kernel_test,gates_lock_test,tests/daemon/ports/gates_lock_test.cc tests/daemon/gates/sandbox.cc daemon/ports/gates_lock.cc,,-lbpf -lfmt))
$(eval $(call kernel_test,change_test,tests/daemon/ports/change_test.cc tests/daemon/gates/sandbox.cc,$(DAEMON_ARCHIVES),$(DAEMON_LIBS) -ldl))
$(eval $(call kernel_test,follow_test,tests/daemon/ports/follow_test.cc tests/daemon/gates/sandbox.cc,$(DAEMON_ARCHIVES),$(DAEMON_LIBS)))
