# The gate: each BPF object becomes a skeleton header. Both sides depend on the shared header
# gate.h.
# CPU v3 has atomic operations that return a value, which every kernel since 5.12 supports.
# BTF names source files relative to the folder of the compilation. With "." the object is the same
# wherever it is built.
BPF_CFLAGS := -target bpf -mcpu=v3 -O2 -g -fdebug-compilation-dir=. -Wall -Werror -I. -I/usr/include/$(shell gcc -print-multiarch 2>/dev/null)
# The skeletons are kept, although make considers them intermediate files.
.PRECIOUS: $O/bpf/%.bpf.o
BPF_SKELETONS := $O/gen/gate.skel.h $O/gen/deadman.skel.h $O/gen/watch.skel.h $O/gen/ether.skel.h $O/gen/ether_watch.skel.h $O/gen/roster.skel.h \
	$O/gen/ether_closed.skel.h $O/gen/gate_closed.skel.h
# The same programs for BPF_PROG_TEST_RUN (bpf/test_skb.bpf.h), which only tests load.
BPF_TEST_SKELETONS := $O/gen/gate_test.skel.h $O/gen/ether_test.skel.h $O/gen/gate_closed_test.skel.h

$O/bpf/%.bpf.o: bpf/%.bpf.c $(wildcard bpf/*.h) core/gates/frame_reasons.inc core/profiles/layout.h core/profiles/list.inc
	$(call say,BPF,$<)
	$(Q)mkdir -p $(@D) && $(CLANG) $(BPF_CFLAGS) -c $< -o $@ && $(LLVM_STRIP) -g $@
$O/gen/%.skel.h: $O/bpf/%.bpf.o
	$(call say,SKEL,$@)
	$(Q)mkdir -p $(@D) && $(BPFTOOL) gen skeleton $< name $*_bpf > $@
