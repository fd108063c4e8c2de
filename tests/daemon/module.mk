$(eval $(call unit_test,leases_test,tests/daemon/leases_test.cc,$O/daemon/leases.o,))
$(eval $(call unit_test,bus_load_test,tests/daemon/bus_load_test.cc,$O/daemon/bus_load.o,))
$(eval $(call unit_test,forwarding_test,tests/daemon/forwarding_test.cc tests/daemon/can_routes_test.cc,$(addprefix $O/daemon/,forwarding.o forwarder.o net/can_routes.o),$(NL_LIBS) -lfmt))
$O/tests/daemon/can_routes_test.o: CPPFLAGS += $(NL_CFLAGS)
