$(eval $(call unit_test,manager_test,tests/daemon/manager_test.cc,$O/daemon/manager.o,))
