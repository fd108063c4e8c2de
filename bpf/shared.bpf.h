/* SPDX-License-Identifier: GPL-2.0-only OR BSD-2-Clause */
/* What the gate programs of all kinds of links have in common. */
#ifndef MLCCA_SHARED_BPF_H
#define MLCCA_SHARED_BPF_H

/* PREEMPT_RT: one program can interrupt another on its CPU. Set before loading. */
const volatile __u8 atomic_counts = false;

/* Other CPUs see the stores of one in its order, as on x86. Set before loading. */
const volatile __u8 ordered_stores = false;

#include "bpf/closed.bpf.h"

/*
 * Another generation than verdicts were read by. The address of the load depends on what was read
 * for the decision, so that no machine does the one before the other.
 */
static __always_inline bool moved_on(__u32 generation, __u32 read)
{
	__u64 nothing = read;

	asm volatile("%0 ^= %0" : "+r"(nothing));
	return READ_ONCE((&control.generation)[nothing & 1]) != generation;
}

/* After all stores before it, and before those that follow. */
static __always_inline void store_in_order(__u64 *at, __u64 value)
{
	if (!ordered_stores) {
		__sync_lock_test_and_set(at, value);
		return;
	}
	asm volatile("" ::: "memory");
	WRITE_ONCE(*at, value);
	asm volatile("" ::: "memory");
}

static __always_inline void add_atomic(__u64 *counter, __u64 n)
{
	__sync_fetch_and_add(counter, n);
}

static __always_inline void add(__u64 *counter, __u64 n)
{
	if (atomic_counts)
		add_atomic(counter, n);
	else
		*counter += n;
}

#endif
