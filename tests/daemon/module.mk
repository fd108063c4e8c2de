$(eval $(call unit_test,leases_test,tests/daemon/leases_test.cc,$O/daemon/leases.o,))
$(eval $(call unit_test,bus_load_test,tests/daemon/bus_load_test.cc,$O/daemon/bus_load.o,))
