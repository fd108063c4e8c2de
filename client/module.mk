# SPDX-License-Identifier: BSD-2-Clause
# libmlcca, with which applications are linked. It exports only mlcca::client; the control protocol
# and everything else in it is hidden.
$(eval $(call library,client,$(wildcard client/*.cc)))

# Before version 1.0 the ABI changes with each minor version, so that is part of the soname.
CLIENT_VERSION := $(shell sed -n 's/.*kVersion\[\] = "\(.*\)";/\1/p' control/version.hpp)
CLIENT_ABI := $(basename $(CLIENT_VERSION))
CLIENT_LIBRARY := $O/libmlcca.so.$(CLIENT_VERSION)
# The sources include the socket code that the relay uses as well.
CLIENT_SOURCES := $(wildcard client/*.cc control/*.cc relay/layers/*.cc) relay/afp.cc relay/cyphal.cc relay/j1939.cc
CLIENT_OBJECTS := $(if $(BUNDLE),$(foreach folder,$(sort $(dir $(CLIENT_SOURCES))),$(call bundle,$O/bundle/pic/$(subst /,-,$(patsubst \
	%/,%,$(folder))),$(call in_folder,$(folder),$(CLIENT_SOURCES)))),$(patsubst %.cc,$O/pic/%.o,$(CLIENT_SOURCES)))
OBJECTS += $(CLIENT_OBJECTS)
$(CLIENT_OBJECTS): CXXFLAGS += -fPIC -fvisibility=hidden

$O/pic/%.o: %.cc | $(CONTROL_HEADERS)
	$(call say,CXX,$< (shared))
	$(Q)mkdir -p $(@D) && $(CXX) $(STD) $(WARN) $(CPPFLAGS) $(CXXFLAGS) -MMD -MP -c $< -o $@

$(CLIENT_LIBRARY): $(CLIENT_OBJECTS) client/exports.map
	$(call say,LINK,$@)
	$(Q)$(CXX) $(LDFLAGS) -shared -Wl,-soname,libmlcca.so.$(CLIENT_ABI) -Wl,--version-script=client/exports.map \
		-Wl,--no-undefined -o $@ $(CLIENT_OBJECTS)
	$(Q)ln -sf $(@F) $O/libmlcca.so.$(CLIENT_ABI) && ln -sf libmlcca.so.$(CLIENT_ABI) $O/libmlcca.so
PROGRAMS += $(CLIENT_LIBRARY)

# The folder in which Debian has libraries of the architecture; elsewhere use `make LIBDIR=…`.
LIBDIR ?= $(PREFIX)/lib$(if $(filter /usr,$(PREFIX)),/$(shell $(CXX) -print-multiarch))
install-client: $(CLIENT_LIBRARY) ## libmlcca for applications, with what pkg-config and CMake need
	$(Q)install -d $(DESTDIR)$(LIBDIR)/pkgconfig $(DESTDIR)$(LIBDIR)/cmake/mlcca $(DESTDIR)$(PREFIX)/include/mlcca/client
	$(Q)install -m 644 $(CLIENT_LIBRARY) $(DESTDIR)$(LIBDIR)
	$(Q)ln -sf $(notdir $(CLIENT_LIBRARY)) $(DESTDIR)$(LIBDIR)/libmlcca.so.$(CLIENT_ABI)
	$(Q)ln -sf libmlcca.so.$(CLIENT_ABI) $(DESTDIR)$(LIBDIR)/libmlcca.so
	$(Q)install -d $(DESTDIR)$(PREFIX)/share/mlcca/proto/mlcca/v1
	$(Q)install -m 644 proto/mlcca/v1/control.proto proto/mlcca/v1/options.proto $(DESTDIR)$(PREFIX)/share/mlcca/proto/mlcca/v1
	$(Q)install -m 644 include/mlcca/client/*.h* $(DESTDIR)$(PREFIX)/include/mlcca/client
	$(Q)for file in mlcca.pc:pkgconfig/mlcca.pc mlcca-config.cmake:cmake/mlcca/mlcca-config.cmake \
		mlcca-config-version.cmake:cmake/mlcca/mlcca-config-version.cmake; do \
		sed -e 's|@PREFIX@|$(PREFIX)|g' -e 's|@LIBDIR@|$(LIBDIR)|g' -e 's|@VERSION@|$(CLIENT_VERSION)|g' \
			-e "s|@TO_PREFIX@|$$(realpath -m --relative-to=$(LIBDIR) $(PREFIX))|g" \
			client/$${file%%:*}.in >$(DESTDIR)$(LIBDIR)/$${file#*:} || exit 1; done
PARTS += install-client
.PHONY: install-client

# The Python package, with the protocol as protoc generates it. The folder is one that Debian's
# Python searches.
PYTHON_DIR ?= $(PREFIX)/lib/$(if $(filter /usr,$(PREFIX)),python3,$(shell python3 -c \
	'import sys; print("python%d.%d" % sys.version_info[:2])'))/dist-packages
install-python: ## the package mlcca for Python 3
	$(Q)install -d $(DESTDIR)$(PYTHON_DIR)/mlcca
	$(Q)install -m 644 client/python/mlcca/*.py client/python/mlcca/py.typed $(DESTDIR)$(PYTHON_DIR)/mlcca
	$(Q)sed -i 's/@ABI@/$(CLIENT_ABI)/' $(DESTDIR)$(PYTHON_DIR)/mlcca/events.py
	$(Q)$(PROTOC) -Iproto --python_out=$(DESTDIR)$(PYTHON_DIR) --pyi_out=$(DESTDIR)$(PYTHON_DIR) \
		mlcca/v1/control.proto mlcca/v1/options.proto
PARTS += install-python
.PHONY: install-python
