# SPDX-License-Identifier: BSD-2-Clause
# The attribute core: headers for every compiler, from an 8-bit node to the daemon.
AVR_CXX ?= avr-g++
CORE_HEADERS := $(wildcard include/mlcca/*.hpp)
FREESTANDING := -std=c++14 -ffreestanding -fno-exceptions -fno-rtti -fsyntax-only -Iinclude
REFUSED_CASES := 1 2 3 4 5 6 7 8 9 10 11

# $(call check_freestanding,COMPILER): each header alone, the laws, and what must not compile
define check_freestanding
$(Q)for header in $(CORE_HEADERS:include/%=%); do \
	echo "#include \"$$header\"" | $1 $(FREESTANDING) -Wall -Wextra -Werror -x c++ - || \
		{ echo "$1 refuses $$header alone"; exit 1; }; \
done
$(Q)$1 $(FREESTANDING) -Wall -Wextra -Werror tests/include/static_laws.cc
$(Q)$1 $(FREESTANDING) -Wall -Wextra -Werror tests/include/refused/units.cc
$(Q)for case in $(REFUSED_CASES); do \
	if $1 $(FREESTANDING) -DCASE=$$case tests/include/refused/units.cc 2>/dev/null; then \
		echo "$1 accepts case $$case of tests/include/refused/units.cc"; exit 1; \
	fi; \
done
@echo '  PASS    $1: $(words $(CORE_HEADERS)) headers, laws, $(words $(REFUSED_CASES)) refusals'
endef

check-mcu: ## the attribute core as freestanding C++14 on every compiler that a node uses
	$(call check_freestanding,$(CXX))
	$(call check_freestanding,$(CLANG))
	$(call check_freestanding,$(AVR_CXX))

install-headers: ## the attribute core below $(DESTDIR)$(PREFIX)/include/mlcca
	$(Q)install -d $(DESTDIR)$(PREFIX)/include/mlcca
	$(Q)install -m 644 $(CORE_HEADERS) $(DESTDIR)$(PREFIX)/include/mlcca
INSTALL += install-headers

.PHONY: check-mcu install-headers
