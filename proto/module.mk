PROTO_LIBS := -lprotobuf-lite
$O/gen/%.pb.cc $O/gen/%.pb.h: proto/%.proto
	$(call say,PROTOC,$<)
	$(Q)mkdir -p $(@D) && $(PROTOC) -Iproto --cpp_out=$O/gen $<
$O/gen/%.pb.o: $O/gen/%.pb.cc
	$(call say,CXX,$<)
	$(Q)$(CXX) $(STD) -w $(CPPFLAGS) $(CXXFLAGS) -MMD -MP -c $< -o $@
PROTO_OBJECTS := $O/gen/mlcca/v1/control.pb.o
