# SPDX-License-Identifier: BSD-2-Clause
# One make process; each folder's module.mk adds to the lists below. `make help` lists the targets.
O ?= build
V ?= 0
SAN ?=
# A warning is an error; `make WERROR=` for another compiler than ours.
WERROR ?= -Werror
PREFIX ?= /usr/local
DESTDIR ?=

CXX ?= g++
ifeq ($(origin CXX),default)
CXX := g++
endif
CLANG ?= clang-19
LLVM_STRIP ?= llvm-strip-19
CLANG_TIDY ?= clang-tidy-19
CLANG_FORMAT ?= clang-format-19
BPFTOOL ?= $(firstword $(wildcard /usr/sbin/bpftool) bpftool)
PROTOC ?= protoc
PKG_CONFIG ?= pkg-config

# -g1 knows the lines of a back trace at two thirds of the time of -g. For gdb: CXXFLAGS='-O0 -g'.
CXXFLAGS ?= -O2 -g1
STD := -std=c++23
WARN := -Wall -Wextra -Wpedantic -Wshadow -Wconversion $(WERROR)
# Below made/ is what files of ours are made of, below gen/ what other generators make of them.
CPPFLAGS += -I. -Iinclude -I$O/made -isystem $O/gen
ifneq ($(SAN),)
CXXFLAGS += -fsanitize=$(SAN) -fno-omit-frame-pointer
LDFLAGS += -fsanitize=$(SAN)
endif

Q := $(if $(filter 1,$V),,@)
say = $(if $(filter 1,$V),,@printf '  %-7s %s\n' '$1' '$2')

.DELETE_ON_ERROR:
.PRECIOUS: %.o %.bpf.o %.skel.h %.pb.cc %.pb.h
.SUFFIXES:
MAKEFLAGS += --no-builtin-rules
ifeq ($(MAKELEVEL)$(filter -j%,$(MAKEFLAGS)),0)
MAKEFLAGS += -j$(shell nproc)
endif

all:

# Lists that the fragments fill.
PROGRAMS := # linked executables
OBJECTS := # every C++ object, for the dependency files
UNIT_TESTS := # test executables that need no privileges
KERNEL_TESTS := # test executables that need root and this kernel
SANITIZED_OBJECTS := # of all tests, under AddressSanitizer and UBSan
PARTS := # targets that install something
CLEAN_EXTRA :=

# BUNDLE=1 compiles the files of one folder of a library as one: headers and templates are read once
# and not forty times, and a build from nothing takes less than half of the processor time. Without it each
# file is compiled alone, so that a change of one file is built in seconds. `make demo` and `make test`
# bundle where no file was compiled alone yet.
BUNDLE ?=
ifeq ($(MAKECMDGOALS),uninstall)
override BUNDLE := # nothing is built
endif
BUNDLE_IF_BARE := $(if $(BUNDLE)$(wildcard $O/core/model/*.o),$(BUNDLE),1)
hash := \#
# Files that must be compiled alone: names of theirs, or of headers that they need, stand in another
# file of the folder too; the compiler warns of values that it loses sight of (wire); or a program
# takes some files of the folder and must not get the libraries of the others (net/sources).
ALONE := $(wildcard core/profiles/*.cc daemon/net/sources/*.cc) core/can/wire.cc core/mesh/medium_time.cc \
	$(addprefix daemon/gates/,control.cc counters.cc pins.cc programs.cc roster.cc silence_timers.cc slot_spec.cc slots.cc) \
	daemon/gateway/quotas.cc daemon/net/pair.cc $(wildcard examples/applications/*.cc) \
	$(addprefix description/,grammar.cc parser.cc read.cc rules.cc source.cc xml.cc) \
	$(addprefix tools/design/,check/check.cc check/page.cc check/watch.cc describe/edit.cc describe/markup.cc generate.cc) \
	$(wildcard tests/include/der/*.cc tests/description/grown/*.cc) tests/support/stretches.cc \
	$(addprefix tools/,report.cc render_reservations.cc render_routes.cc render_system.cc sources/olsr.cc values.cc words.cc)
# $(call objects_of,NAME,SOURCES)
objects_of = $(if $(BUNDLE),$(foreach folder,$(sort $(dir $2)),$(call objects_of_folder,$1,$(folder),$(filter-out \
	$(ALONE),$(call in_folder,$(folder),$2)))) $(patsubst %.cc,$O/%.o,$(filter $(ALONE),$2)),$(patsubst %.cc,$O/%.o,$2))
in_folder = $(foreach file,$2,$(if $(filter $1,$(dir $(file))),$(file)))
objects_of_folder = $(if $(word 3,$3),$(call bundle,$O/bundle/$(subst /,-,$1)/$(subst /,-,$(patsubst %/,%,$2)),$3),$(3:%.cc=$O/%.o))
bundle = $(shell mkdir -p $(dir $1) && printf '$(hash)include "%s"\n' $2 >$1.new && \
	if cmp -s $1.new $1.cc; then rm $1.new; else mv $1.new $1.cc; fi)$1.o

# $(call parts,FILE,OBJECTS) is a file that has the names of the objects, and is written when they are others. What is
# linked depends on it, so that it is linked again when an object is left out, too.
parts = $(if $(filter uninstall clean help,$(MAKECMDGOALS)),,$(call write_parts,$1.parts,$(patsubst $O/%,%,$2)))$1.parts
write_parts = $(if $(subst +$(strip $2),,+$(file <$1))$(subst +$(file <$1),,+$(strip $2)),$(shell mkdir \
	-p $(dir $1))$(file >$1,$(strip $2)))

# $(call library,NAME,SOURCES) gives build/libNAME.a
define library
$1_objects := $$(call objects_of,$1,$2)
OBJECTS += $$($1_objects)
$O/lib$1.a: $$($1_objects) $$(call parts,$O/lib$1.a,$$($1_objects))
	$$(call say,AR,$$@)
	$$(Q)rm -f $$@ && ar rcs $$@ $$($1_objects)
endef

# $(call program,FILE,SOURCES,ARCHIVES,LIBS)
program = $(call linked,$1,$(2:%.cc=$O/%.o),$3,$4)
define linked
$(notdir $1)_objects := $2
OBJECTS += $$($(notdir $1)_objects)
$O/$1: $$($(notdir $1)_objects) $$(call parts,$O/$1,$$($(notdir $1)_objects)) $3
	$$(call say,LINK,$$@)
	$$(Q)mkdir -p $$(@D) && $$(CXX) $$(LDFLAGS) -o $$@ $$($(notdir $1)_objects) $3 $4
endef

# Tests are bundled by program (tests/module.mk). NAME_bundles is of $O/bundle/tests.mk, which is made of
# NAME_bundled.
test_objects = $(if $(and $(TEST_BUNDLES),$(word 2,$2)),$(patsubst %,$O/bundle/tests/$1/%.o,$($1_bundles))$(patsubst \
	%.cc, $O/%.o,$(filter-out $($1_bundled),$2)),$(2:%.cc=$O/%.o))

bundled_test = $(if $(word 2,$2),$(eval $1_bundled := $(filter-out $(ALONE),$(filter tests/%,$2)))$(eval BUNDLED_TESTS += $1))
# $(call unit_test,NAME,SOURCES,ARCHIVES,LIBS): needs no privileges. kernel_test: needs root.
define unit_test
$(call bundled_test,$1,$2)
$(call linked,tests/$1,$(call test_objects,$1,$2),$3,$4 -lgtest_main -lgtest -lpthread)
UNIT_TESTS += $O/tests/$1
$(call sanitized_test,$1,$2,$3,$4)
endef
define kernel_test
$(call bundled_test,$1,$2)
$(call linked,tests/$1,$(call test_objects,$1,$2),$3,$4 -lgtest_main -lgtest -lpthread)
KERNEL_TESTS += $O/tests/$1
$(call sanitized_test,$1,$2,$3,$4)
endef
# The same test of the objects that fuzz targets are made of (tests/fuzz/module.mk).
define sanitized_test
SANITIZED_OBJECTS += $$($1_objects:$O/%=$O/fuzz/obj/%)
$O/fuzz/tests/$1: $$($1_objects:$O/%=$O/fuzz/obj/%) \
		$$(patsubst $O/lib%.a,$O/fuzz/lib%.a,$$(patsubst $O/%.o,$O/fuzz/obj/%.o,$3)) $O/tests/$1.parts
	$$(call say,LINK,$$@)
	$$(Q)mkdir -p $$(@D) && $$(FUZZ_CXX) -fsanitize=$$(FUZZ_SANITIZERS) -o $$@ $$(filter-out %.parts,$$^) $4 -lgtest_main -lgtest \
		-lpthread -lfmt
endef

include deps.mk
include core/module.mk description/module.mk proto/module.mk control/module.mk client/module.mk relay/module.mk bpf/module.mk
include daemon/module.mk cluster/module.mk tools/module.mk include/module.mk systemd/module.mk tests/module.mk
include examples/module.mk docs/module.mk cockpit/module.mk

all: $(PROGRAMS) ## build mlccad, mlccactl and the gate

$O/%.o: %.cc | $(CONTROL_HEADERS)
	$(call say,CXX,$<)
	$(Q)mkdir -p $(@D) && $(CXX) $(STD) $(WARN) $(CPPFLAGS) $(CXXFLAGS) -MMD -MP -c $< -o $@

$O/bundle/%.o: $O/bundle/%.cc | $(CONTROL_HEADERS)
	$(call say,CXX,$(patsubst $O/bundle/%.cc,%,$<))
	$(Q)$(CXX) $(STD) $(WARN) -Wno-subobject-linkage $(CPPFLAGS) $(CXXFLAGS) -MMD -MP -c $< -o $@

-include $(OBJECTS:.o=.d)
# Of files that a test takes alone while BUNDLE=1 builds their folder as one.
-include $(filter-out $(OBJECTS:.o=.d),$(wildcard $(foreach folder,control daemon/* tools/* core/*,$O/$(folder)/*.d)))

# --- what a person calls ---------------------------------------------------------------------------

demo: ensure-deps ## the emergency stop, shown on real SocketCAN and systemd (DEMO=host: on this kernel)
	$(Q)$(MAKE) BUNDLE=$(BUNDLE_IF_BARE) run-demo

test: ensure-deps ## everything: layers, format, unit, kernel and guest tests
	$(Q)$(MAKE) BUNDLE=$(BUNDLE_IF_BARE) test-all

test-all:
	$(Q)$(MAKE) all check-layers check-format cppcheck tidy check-mcu
	$(Q)$(MAKE) FUZZ_OPT=-O0 check-node check-fuzz check-work check-sanitized check-plain check-docs check-install check-reproducible check-fault check-memory check-torn check-cluster check-neighbour check-quotas check-client check-exporter check-cockpit
	$(Q)$(MAKE) check-harness check-guest

lint: check-layers check-format cppcheck tidy ## layering, clang-format-19, cppcheck and clang-tidy-19

# Nothing here needs a compiler: seconds before every commit.
check-quick: check-layers check-format ## what a commit breaks most easily: layers, names, format, form and dates of documents
	$(Q)tests/docs/form
	$(Q)tests/bench/age check

check-layers: ## who may include whom, and no name that means another thing in a bundle
	$(Q)tests/support/check-layers
	$(Q)tests/support/check-bundles

FORMATTED = $(shell git ls-files '*.cc' '*.hpp' '*.h' '*.c' 2>/dev/null || true)
check-format:
	$(call say,FORMAT,$(words $(FORMATTED)) files)
	$(Q)$(CLANG_FORMAT) --dry-run -Werror $(FORMATTED)
format: ## format every file in place
	$(Q)$(CLANG_FORMAT) -i $(FORMATTED)

PRODUCT = $(shell tests/support/product-folders)
# False alarms are listed with their reasons; what is wrong is corrected.
cppcheck: ## defects that cppcheck finds without the headers of libraries
	$(call say,CPPCHK,$(filter-out bpf include,$(PRODUCT)))
	$(Q)cppcheck -q -j2 --std=c++20 --language=c++ --enable=warning,performance,portability --max-configs=1 \
		--suppress=missingInclude --suppressions-list=tests/support/cppcheck.supp --error-exitcode=1 \
		-D__x86_64__ -D'LIBBPF_OPTS(TYPE,NAME,...)=struct TYPE NAME{}' -Iinclude -I. $(filter-out bpf include,$(PRODUCT))

# clang-tidy matches every check against the headers of a file, too, and for most files they are nine
# tenths of its time. So it takes a part of the tree as one file, which includes the files of the part; of
# ALONE it takes one file of each folder. One stamp a bundle: what did not change is not checked again.
TIDY_PARTS := core cluster control client relay/famouso relay description daemon/gateway daemon/net/sources daemon tools/awds tools/can \
	tools/design/generate tools/design/import tools/design/export tools/design tools/doctor tools/readback tools/sources \
	tools/learn tools/exporter tools/report tools
ifneq ($(filter tidy lint analyse,$(MAKECMDGOALS)),)
tidy_rest := $(filter-out tests/% include/% bpf/%,$(shell git ls-files '*.cc'))
tidy_alone := $(filter-out daemon/net/sources/%,$(filter $(ALONE),$(tidy_rest)))
tidy_rest := $(filter-out $(tidy_alone),$(tidy_rest))
tidy_bundle = $(if $(strip $2),$(eval TIDY_BUNDLES += $(call bundle,$O/tidy/$(subst /,-,$1),$2)))
$(foreach part,$(TIDY_PARTS),$(call tidy_bundle,$(part),$(filter $(part)/%,$(tidy_rest)))$(eval \
	tidy_rest := $(filter-out $(part)/%,$(tidy_rest))))
$(call tidy_bundle,rest,$(tidy_rest))
$(foreach n,1 2 3 4 5 6 7 8 9,$(call tidy_bundle,alone-$n,$(foreach folder,$(sort $(dir $(tidy_alone))),$(word \
	$n,$(call in_folder,$(folder),$(tidy_alone))))))
$(call tidy_bundle,include,$(filter-out include/mlcca/client/%,$(shell git ls-files 'include/*.h*')))
TIDY_STAMPS := $(TIDY_BUNDLES:.o=.ok)
$O/tidy/include.%: STD := -std=c++14
$O/tidy/include.%: TIDY_FLAGS := --header-filter='^include/'
# The attribute core has no <cstddef> on a small node, names what a compiler is to print in capitals, and is
# written so that few instructions are made of it (make check-node).
$O/tidy/include.%: TIDY_OFF := ,-modernize-deprecated-headers,-readability-identifier-naming,-readability-avoid-nested-conditional-operator,-readability-function-cognitive-complexity
endif
TIDY_CPPFLAGS = $(STD) $(CPPFLAGS) $(XML_CFLAGS) $(NL_CFLAGS)
comma := ,
tidy_run = $(CLANG_TIDY) --quiet --checks='$1' $(TIDY_FLAGS) $< -- $2 $(TIDY_CPPFLAGS) 2>$@.log || { cat $@.log; exit 1; }
$O/tidy/%.ok: $O/tidy/%.cc .clang-tidy | $(BPF_SKELETONS) $(CONTROL_HEADERS) $(DESCRIPTION_TABLES) $O/gen/report_page.inc $O/gen/check_page.inc
	$(call say,TIDY,$* ($(words $(filter-out %include,$(shell cat $<))) files))
	$(Q)$(call tidy_run,-clang-analyzer-*$(comma)-misc-unused-using-decls$(TIDY_OFF))
	$(Q)$(CXX) $(TIDY_CPPFLAGS) -MM -MP -MT $@ -MF $(@:.ok=.d) $<
	$(Q)touch $@
# The analyzer takes functions of the main file only, unless headers are analysed, too.
$O/tidy/%.analysed: $O/tidy/%.cc $O/tidy/%.ok
	$(call say,ANALYSE,$*)
	$(Q)$(call tidy_run,-*$(comma)clang-analyzer-*,-Xclang -analyzer-opt-analyze-headers)
	$(Q)touch $@
-include $(TIDY_STAMPS:.ok=.d)
tidy: $(TIDY_STAMPS)
analyse: $(TIDY_STAMPS:.ok=.analysed) ## the static analyzer of clang: half an hour and more

bench: ensure-deps ## ratios against named peers in the same run (root)
	$(Q)$(MAKE) run-bench
	$(Q)$(MAKE) run-bench-frames
	$(Q)$(MAKE) run-bench-relay

install: all $(PARTS) ## install below $(DESTDIR)$(PREFIX); units and rules where the system looks for them

# What `make install` would put there is seen in a folder beside; programs are empty files for that, so that
# nothing is compiled. Folders of other programs stay, and in /etc what somebody has changed.
uninstall: ## remove what `make install` of the same variables has put there; PARTS=install-client: this alone
	$(Q)scratch=$$(mktemp -d) && trap 'rm -rf $$scratch' EXIT && mkdir $$scratch/build && \
	touch $(patsubst $O/%,$$scratch/build/%,$(PROGRAMS) $(MADE_PAGES)) && \
	$(MAKE) --no-print-directory O=$$scratch/build BUNDLE= DESTDIR=$$scratch/root $(patsubst $O/%,-o $$scratch/build/%,$(PROGRAMS) $(MADE_PAGES)) \
		$(PARTS) >/dev/null && cd $$scratch/root && \
	find . ! -type d | while read -r file; do there=$(abspath $(DESTDIR))/$${file#./}; case $$file in \
		./etc/*) if [ -e $$there ] && ! cmp -s $$file $$there; then echo "$$there has been changed and stays"; continue; fi;; esac; \
		rm -f $$there || exit 1; done && \
	find . -depth -type d -path '*/mlcca*' | while read -r folder; do there=$(abspath $(DESTDIR))/$${folder#./}; \
		[ ! -d $$there ] || rmdir --ignore-fail-on-non-empty $$there || exit 1; done

check-install: all $(MADE_PAGES) ## uninstall takes away what install has brought, and nothing else
	$(Q)+tests/support/check-install $O

check-reproducible: ## two builds from different places are the same octets; of all packages: check-reproducible-packages
	$(Q)tests/support/check-reproducible
check-reproducible-packages:
	$(Q)tests/support/check-reproducible --packages

clean: ## remove the build tree
	$(Q)rm -rf $O $(CLEAN_EXTRA)

help: ## list the targets
	@awk -F':.*## ' '/^[a-z-]+:.*## /{printf "  make %-14s %s\n", $$1, $$2}' $(MAKEFILE_LIST)
	@echo "  variables      O=build V=1 SAN=address,undefined DESTDIR= PREFIX=/usr/local CXX= CXXFLAGS="

.PHONY: all demo test test-all lint check-quick check-layers check-format format cppcheck tidy analyse bench install uninstall check-install check-reproducible check-reproducible-packages clean help
