$(eval $(call unit_test,leases_test,tests/daemon/leases_test.cc,$O/daemon/leases.o,))
