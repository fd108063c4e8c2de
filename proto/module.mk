# SPDX-License-Identifier: BSD-2-Clause
# Generates the structs of the control protocol, the journal and the store of a cluster from their
# schemas.
PROTO_FILES := $(wildcard proto/mlcca/v1/*.proto)
CONTROL_HEADERS := $(foreach folder,control daemon/store daemon/cluster,$(addprefix $O/made/$(folder)/,messages.hpp oneofs.inc fields.hpp))
# $(call schema,FOLDER,FILE)
define schema
$O/made/$1/fields.hpp $O/made/$1/oneofs.inc: $O/made/$1/messages.hpp ;
$O/made/$1/messages.hpp: proto/protoc-gen-mlcca $(PROTO_FILES)
	$$(call say,PROTOC,$$@)
	$$(Q)mkdir -p $O/made && $$(PROTOC) -Iproto --plugin=protoc-gen-mlcca=proto/protoc-gen-mlcca \
		--mlcca_out=$1:$O/made mlcca/v1/$2.proto
endef
$(eval $(call schema,control,control))
$(eval $(call schema,daemon/store,journal))
$(eval $(call schema,daemon/cluster,cluster))

# The code that protobuf itself generates, with which tests compare ours.
$O/gen/%.pb.cc $O/gen/%.pb.h: proto/%.proto
	$(call say,PROTOC,$<)
	$(Q)mkdir -p $(@D) && $(PROTOC) -Iproto --cpp_out=$O/gen $<
$O/gen/%.pb.o: $O/gen/%.pb.cc
	$(call say,CXX,$<)
	$(Q)$(CXX) $(STD) -w $(CPPFLAGS) $(CXXFLAGS) -MMD -MP -c $< -o $@
PROTOBUF_OBJECTS := $O/gen/mlcca/v1/control.pb.o $O/gen/mlcca/v1/options.pb.o
PROTOBUF_HEADERS := $(PROTOBUF_OBJECTS:.o=.h)
$(PROTOBUF_OBJECTS): $O/gen/mlcca/v1/options.pb.h
$O/tests/control/protobuf_test.o $O/fuzz/obj/tests/control/protobuf_test.o: | $(PROTOBUF_HEADERS)
