// SPDX-License-Identifier: GPL-2.0-only OR BSD-2-Clause
/* The silence timers of an Ethernet gate. A watch states its slot. */
#include <stdbool.h>
#include <linux/bpf.h>
#include <linux/errno.h>
#include <linux/pkt_cls.h>
#include <linux/time.h> /* CLOCK_MONOTONIC */
#include <bpf/bpf_helpers.h>

#include "bpf/ether.h"
#include "bpf/once.bpf.h"
#include "bpf/ether_maps.bpf.h"

#define WATCHES ETHER_WATCHES

#include "bpf/silence_timers.bpf.h"

static __u32 watches_end(void) { return READ_ONCE(table.watches_end); }

static struct gate_watch *watch_of(__u32 at) { return bpf_map_lookup_elem(&watches, &at); }

static struct ether_slot *slot_of(const struct gate_watch *w)
{
	__u32 at = READ_ONCE(w->slot);

	return bpf_map_lookup_elem(&slots, &at);
}

static __u64 subject_of(__u32 at, const struct gate_watch *w)
{
	const struct ether_slot *slot = slot_of(w);

	return slot ? slot->subject : 0;
}

static __u32 slot_number(__u32 at, const struct gate_watch *w) { return READ_ONCE(w->slot); }

static bool passes(__u32 at, const struct gate_watch *w)
{
	const struct ether_slot *slot = slot_of(w);

	return slot && READ_ONCE(slot->watch) == at && passes_now(slot->verdict);
}

char LICENSE[] SEC("license") = "Dual BSD/GPL";
