$(eval $(call unit_test,control_test,$(wildcard tests/control/*.cc),$O/libcontrol.a $(PROTOBUF_OBJECTS),-lprotobuf))
