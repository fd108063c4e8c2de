$(eval $(call unit_test,doctor_test,$(wildcard tests/tools/doctor/*.cc),$O/libdoctor.a $(DAEMON_ARCHIVES),$(DAEMON_LIBS)))
