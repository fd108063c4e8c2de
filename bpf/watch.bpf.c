// SPDX-License-Identifier: GPL-2.0-only OR BSD-2-Clause
/* The silence timers of a CAN gate. Each slot has a watch of its own. */
#include <stdbool.h>
#include <linux/bpf.h>
#include <linux/errno.h>
#include <linux/pkt_cls.h>
#include <linux/time.h> /* CLOCK_MONOTONIC */
#include <bpf/bpf_helpers.h>

#include "bpf/gate.h"
#include "bpf/once.bpf.h"

#define WATCHES GATE_SLOTS

struct gate_table table; /* of .bss: it is the table of the gate */

#include "bpf/silence_timers.bpf.h"

static __u32 watches_end(void) { return READ_ONCE(table.slots_end); }

static struct gate_watch *watch_of(__u32 at) { return &table.watches[at & (GATE_SLOTS - 1)]; }

static __u64 subject_of(__u32 at, const struct gate_watch *w)
{
	return table.slots[at & (GATE_SLOTS - 1)].subject;
}

static __u32 slot_number(__u32 at, const struct gate_watch *w) { return at; }

static bool passes(__u32 at, const struct gate_watch *w)
{
	return passes_now(table.slots[at & (GATE_SLOTS - 1)].verdict);
}

char LICENSE[] SEC("license") = "Dual BSD/GPL";
