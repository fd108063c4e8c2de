$(eval $(call library,control,$(wildcard control/*.cc)))
$(control_objects): | $O/gen/mlcca/v1/control.pb.h
$O/libcontrol.a: $(PROTO_OBJECTS)
