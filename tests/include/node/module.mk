# SPDX-License-Identifier: BSD-2-Clause
# The attribute core on simulated nodes: ATmega with simavr, Cortex-M3 with QEMU.
AVR_CXX ?= avr-g++
ARM_CXX ?= arm-none-eabi-g++
NODE_COMPILERS = $(lastword $(CXX)) clang++-14 clang++-19 $(AVR_CXX) $(ARM_CXX)
NODE_CASES := 1 2 3 4 5 6 7
NODE_FLAGS := -std=c++14 -Os -ffreestanding -fno-exceptions -fno-rtti -fno-threadsafe-statics \
	-ffunction-sections -fdata-sections -Wl,--gc-sections $(WARN) -Iinclude -Itests/include/node
AVR_FLAGS := -mrelax -DF_CPU=16000000UL
ARM_FLAGS := -mcpu=cortex-m3 -mthumb -nostdlib -T tests/include/node/arm/link.ld
NODE_HEADERS := $(wildcard include/mlcca/*.hpp tests/include/node/*.hpp tests/include/node/size/*.hpp) tests/include/node/arm/link.ld
NODE_PROGRAMS :=

# $(call node_program,BOARD,NAME,COMPILER AND FLAGS,SOURCES)
define node_program
$O/node/$1/$2.elf: $4 $(NODE_HEADERS)
	$$(call say,NODE,$1 $2)
	$$(Q)mkdir -p $$(@D) && $3 $(NODE_FLAGS) $4 -o $$@
NODE_PROGRAMS += $O/node/$1/$2.elf
endef
# $(call node_size_program,BOARD,COMPILER AND FLAGS,NAME,SOURCE,BITS,BOARD SOURCES)
node_size_program = $(call node_program,$1,$3,$2 -DUNITS=mlcca::Units$5,tests/include/node/size/$4.cc tests/include/node/size/main.cc $6)
# $(call node_board,BOARD,COMPILER AND FLAGS,BOARD SOURCES,START-UP THAT A PROGRAM OF ANY SIZE NEEDS)
define node_board
$(call node_program,$1,emergency_switch,$2,tests/include/node/emergency_switch.cc $3)
$(call node_size_program,$1,$2,empty,empty,16,$4)
$(call node_size_program,$1,$2,compile_time,compile_time,16,$4)
$(call node_size_program,$1,$2,check16,check,16,$4)
$(call node_size_program,$1,$2,check32,check,32,$4)
$(call node_size_program,$1,$2,decode16,decode,16,$4)
$(call node_size_program,$1,$2,decode32,decode,32,$4)
endef
$(eval $(call node_board,atmega328p,$$(AVR_CXX) -mmcu=atmega328p $(AVR_FLAGS),tests/include/node/avr/board.cc))
$(eval $(call node_board,atmega128,$$(AVR_CXX) -mmcu=atmega128 $(AVR_FLAGS),tests/include/node/avr/board.cc))
$(eval $(call node_board,cortex-m3,$$(ARM_CXX) $(ARM_FLAGS),tests/include/node/arm/board.cc,tests/include/node/arm/board.cc))

# Checks what holds at compile time, and what must not compile.
NODE_PROOF = -std=c++14 -ffreestanding -fno-exceptions -fno-rtti -fsyntax-only -Iinclude -Wall -Wextra \
	-Werror tests/include/der/static_proof.cc
check-node-proof:
	$(Q)for compiler in $(NODE_COMPILERS); do \
		$$compiler $(NODE_PROOF) || exit 1; \
		for case in $(NODE_CASES); do \
			if $$compiler $(NODE_PROOF) -DCASE=$$case 2>/dev/null; then \
				echo "$$compiler accepts case $$case of tests/include/der/static_proof.cc"; exit 1; \
			fi; \
		done; \
		echo "  PASS    $$compiler: encodings and narrow checks at compile time, $(words $(NODE_CASES)) refusals"; \
	done

check-node: check-node-proof $(NODE_PROGRAMS) ## the attribute core on simulated nodes: verdicts, flash, RAM, cycles
	$(Q)tests/include/node/check $O/node
	$(Q)tests/include/node/costs $O/node

# The bench shows the costs as well.
run-bench: $(NODE_PROGRAMS)

.PHONY: check-node check-node-proof
