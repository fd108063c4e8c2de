$(eval $(call unit_test,control_test,$(wildcard tests/control/*.cc),$O/libcontrol.a,$(PROTO_LIBS)))
