// SPDX-License-Identifier: GPL-2.0-only OR BSD-2-Clause
/*
 * Lists the programs of this kernel that are gates of ours, whoever has loaded them: those that use
 * a map with the name of the control word. To get a program from the kernel by its id,
 * CAP_SYS_ADMIN is needed; for an iterator, CAP_BPF and CAP_PERFMON suffice. Offsets are those of
 * the running kernel's BTF.
 */
#include <linux/bpf.h>
#include <bpf/bpf_helpers.h>
#include <bpf/bpf_core_read.h>

#include "bpf/gate.h"

#pragma clang attribute push(__attribute__((preserve_access_index)), apply_to = record)

struct bpf_map {
	char name[16];
};

struct bpf_prog_aux {
	__u32 id;
	__u32 used_map_cnt;
	struct bpf_map **used_maps;
	char name[16];
};

struct bpf_prog {
	struct bpf_prog_aux *aux;
};

struct seq_file;

struct bpf_iter_meta {
	struct seq_file *seq;
};

struct bpf_iter__bpf_prog {
	struct bpf_iter_meta *meta;
	struct bpf_prog *prog;
};

#pragma clang attribute pop

#define MOST_MAPS 32 /* ours use 13 */

static __always_inline int is_control(const char *name)
{
	const char wanted[] = GATE_CONTROL_NAME;
	__u32 i;

#pragma unroll
	for (i = 0; i < sizeof(wanted); i++)
		if (name[i] != wanted[i])
			return 0;
	return 1;
}

SEC("iter/bpf_prog")
int gate_roster(struct bpf_iter__bpf_prog *ctx)
{
	struct bpf_prog *prog = ctx->prog;
	struct gate_program entry = {};
	struct bpf_prog_aux *aux;
	struct bpf_map **maps;
	__u32 count, i;

	if (!prog)
		return 0;
	aux = prog->aux;
	maps = aux->used_maps;
	count = aux->used_map_cnt;
	for (i = 0; i < MOST_MAPS && i < count; i++) {
		struct bpf_map *map = NULL;
		char name[16] = {};

		if (bpf_probe_read_kernel(&map, sizeof(map), &maps[i]) || !map)
			continue;
		bpf_core_read(name, sizeof(name), &map->name);
		if (!is_control(name))
			continue;
		entry.id = aux->id;
		bpf_probe_read_kernel(entry.name, sizeof(entry.name), aux->name);
		bpf_seq_write(ctx->meta->seq, &entry, sizeof(entry));
		return 0;
	}
	return 0;
}

char LICENSE[] SEC("license") = "Dual BSD/GPL";
