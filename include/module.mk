# SPDX-License-Identifier: BSD-2-Clause
# The attribute core: headers for every compiler, on an 8-bit node as in the daemon.
AVR_CXX ?= avr-g++
ARM_CXX ?= arm-none-eabi-g++
CLANG14 ?= clang-14
CORE_HEADERS := $(wildcard include/mlcca/*.hpp)
FAMOUSO_HEADERS := $(wildcard include/mlcca/famouso/*.h)
MCU_COMPILERS := $(lastword $(CXX)) $(CLANG14) $(CLANG) $(AVR_CXX) $(ARM_CXX)
FREESTANDING := -std=c++14 -ffreestanding -fno-exceptions -fno-rtti -fsyntax-only -Iinclude \
	-Wall -Wextra -Wpedantic -Wconversion -Werror

# $(call check_freestanding,COMPILER) compiles each header alone, and the tests of the laws.
define check_freestanding
$(Q)for header in $(CORE_HEADERS:include/%=%) $(FAMOUSO_HEADERS:include/%=%); do \
	echo "#include \"$$header\"" | $1 $(FREESTANDING) -x c++ - || \
		{ echo "$1 refuses $$header alone"; exit 1; }; \
done
$(Q)$1 $(FREESTANDING) tests/include/static_laws.cc
@echo '  PASS    $1: $(words $(CORE_HEADERS) $(FAMOUSO_HEADERS)) headers, laws'

endef

check-mcu: ## the attribute core and the compile-time check on every compiler that a node uses
	$(foreach compiler,$(MCU_COMPILERS),$(call check_freestanding,$(compiler)))
	$(Q)tests/include/compile/run $(MCU_COMPILERS)

install-headers: ## the attribute core below $(DESTDIR)$(PREFIX)/include/mlcca
	$(Q)install -d $(DESTDIR)$(PREFIX)/include/mlcca/famouso
	$(Q)install -m 644 $(CORE_HEADERS) $(DESTDIR)$(PREFIX)/include/mlcca
	$(Q)install -m 644 $(FAMOUSO_HEADERS) $(DESTDIR)$(PREFIX)/include/mlcca/famouso
PARTS += install-headers

.PHONY: check-mcu install-headers
