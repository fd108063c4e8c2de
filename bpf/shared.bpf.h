/* SPDX-License-Identifier: GPL-2.0-only OR BSD-2-Clause */
/* The parts that the gate programs of all kinds of links share. */
#ifndef MLCCA_SHARED_BPF_H
#define MLCCA_SHARED_BPF_H

/* Set before loading. PREEMPT_RT: a program can interrupt another one on its CPU. */
const volatile __u8 atomic_counts = false;

/* Set before loading. Other CPUs see the stores of one CPU in its order, as on x86. */
const volatile __u8 ordered_stores = false;

#include "bpf/closed.bpf.h"

/*
 * Whether the generation has changed since the verdicts were read. The address of the load depends
 * on what was read for the decision, so that no machine reorders the two.
 */
static __always_inline bool moved_on(__u32 generation, __u32 read)
{
	__u64 nothing = read;

	asm volatile("%0 ^= %0" : "+r"(nothing));
	return READ_ONCE((&control.generation)[nothing & 1]) != generation;
}

/* Stores after all earlier stores and before all later ones. */
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
