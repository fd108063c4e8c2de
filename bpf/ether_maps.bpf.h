/* SPDX-License-Identifier: GPL-2.0-only OR BSD-2-Clause */
/* The maps that the Ethernet gate and its silence timers share. */
#ifndef MLCCA_ETHER_MAPS_BPF_H
#define MLCCA_ETHER_MAPS_BPF_H

#define MAPPED_ARRAY(name, value_type)                                                             \
	struct {                                                                                   \
		__uint(type, BPF_MAP_TYPE_ARRAY);                                                  \
		__uint(map_flags, BPF_F_MMAPABLE);                                                 \
		__uint(max_entries, 1); /* set before loading */                                   \
		__type(key, __u32);                                                                \
		__type(value, value_type);                                                         \
	} name SEC(".maps")

struct ether_table table; /* the only variable of .bss: this map is pinned and memory-mapped */

MAPPED_ARRAY(slots, struct ether_slot);
MAPPED_ARRAY(watches, struct gate_watch);

#endif
