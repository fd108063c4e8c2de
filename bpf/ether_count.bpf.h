/* SPDX-License-Identifier: GPL-2.0-only OR BSD-2-Clause */
/*
 * Exact counters for Ethernet, like gate_count.bpf.h. If a table has one bank of counters for all
 * CPUs, they are updated atomically.
 */
#ifndef MLCCA_ETHER_COUNT_BPF_H
#define MLCCA_ETHER_COUNT_BPF_H

static __always_inline struct ether_cpu *this_cpu(void)
{
	__u32 key = bpf_get_smp_processor_id();

	return bpf_map_lookup_elem(&cpus, &key);
}

static __always_inline struct gate_count *count_of(__u32 slot)
{
	__u32 at = banks == 1 ? slot : bpf_get_smp_processor_id() * slots_of_bank + slot;

	return bpf_map_lookup_elem(&counts, &at);
}

static __always_inline void count_up(__u64 *counter, __u64 n)
{
	if (banks == 1)
		add_atomic(counter, n);
	else
		add(counter, n);
}

static __always_inline void count_reason(struct ether_cpu *cpu, __u32 direction, __u32 reason)
{
	add(&cpu->reasons[direction][reason & (GATE_REASONS - 1)], 1);
}

static __always_inline void count_pass(struct ether_cpu *cpu, __u32 direction, __u32 slot,
				       const struct event *e)
{
	struct gate_count *count = count_of(slot);

	count_reason(cpu, direction, GATE_R_PASSED);
	if (!count)
		return;
	count_up(&count->passed, 1);
	count_up(&count->bytes, e->len);
}

static __always_inline void report_unknown(__u64 frames, __u32 direction, const struct event *e)
{
	struct gate_sample sample = {
	    .ifindex = ifindex,
	    .frames = frames,
	    .subject = e->subject,
	    .len = e->len,
	    .direction = direction,
	    .station = e->station,
	    .audit = READ_ONCE(control.mode) == GATE_AUDIT,
	};

	__builtin_memcpy(sample.mac, e->mac, sizeof(sample.mac));

	report_sample(&sample, &table.sample_due);
}

/* The sequence is 0 while the entry is reused for another subject. */
static __always_inline void note_unknown(struct ether_cpu *cpu, __u32 direction,
					 const struct event *e)
{
	__u32 at = ether_hash(0, e->subject, direction);
	struct ether_seen *seen = &cpu->seen[at & (GATE_SEEN - 1)];
	__u64 sequence = __sync_fetch_and_add(&table.unknown_frames, 1) + 1;

	if (!seen->sequence || seen->subject != e->subject || seen->direction != direction) {
		store_in_order(&seen->sequence, 0);
		seen->subject = e->subject;
		seen->direction = direction;
		seen->count = 0;
		report_unknown(sequence, direction, e);
	}
	seen->len = e->len;
	seen->station = e->station;
	__builtin_memcpy(seen->mac, e->mac, sizeof(seen->mac));
	seen->count++;
	store_in_order(&seen->sequence, sequence);
}

static __always_inline bool is_sender(const struct ether_sender *there,
				      const struct ether_sender *who)
{
	return there->sequence && there->subject == who->subject &&
	       there->station == who->station && there->slot == who->slot &&
	       there->source == who->source && there->uid == who->uid &&
	       there->direction == who->direction && there->reason == who->reason &&
	       !__builtin_memcmp(there->mac, who->mac, sizeof(who->mac));
}

static __always_inline __u32 sender_set(const struct ether_sender *who)
{
	return gate_sender_set(who->station + who->slot, (__u64)who->source << 32 | who->uid);
}

#define SENDER ether_sender
#include "bpf/senders.bpf.h"

/* Whether reports state who has sent what is refused for this reason. */
static __always_inline bool names_sender(__u32 reason)
{
	return reason == GATE_R_UNKNOWN || reason == GATE_R_SOURCE;
}

/* Notes what is dropped, or in audit mode would be. */
static __always_inline void note_refusal(struct ether_cpu *cpu, __u32 direction, __u32 at,
					 __u32 reason, const struct event *e)
{
	struct ether_slot *slot = bpf_map_lookup_elem(&slots, &at);

	if (reason == GATE_R_UNKNOWN)
		note_unknown(cpu, direction, e);
	if (reason == GATE_R_SOURCE && at >= ETHER_FIRST_SLOT) {
		struct ether_sender who = {
		    .subject = e->subject,
		    .station = e->station,
		    .slot = at,
		    .source = direction == GATE_EGRESS ? e->source : 0,
		    .uid = direction == GATE_EGRESS ? e->uid : GATE_ANY_UID,
		    .len = e->len,
		    .direction = direction,
		    .reason = reason,
		};

		__builtin_memcpy(who.mac, e->mac, sizeof(who.mac));
		note_sender(&who);
	}
	if (slot)
		slot->last_reason = reason;
}

static __always_inline void count_would_drop(__u32 direction, __u32 at, __u32 reason)
{
	struct gate_audit *audit = bpf_map_lookup_elem(&audits, &at);

	add_atomic(&table.would_drop[direction][reason & (GATE_REASONS - 1)], 1);
	if (!audit)
		return;
	add_atomic(&audit->would_drop, 1);
	if (reason == GATE_R_EXCESS)
		add_atomic(&audit->would_exceed, 1);
}

static __always_inline void count_drop(struct ether_cpu *cpu, __u32 direction, __u32 at,
				       __u32 reason, const struct event *e)
{
	struct gate_count *count = count_of(at);

	note_refusal(cpu, direction, at, reason, e);
	count_reason(cpu, direction, reason);
	if (!count)
		return;
	count_up(&count->dropped, 1);
	if (reason == GATE_R_EXCESS)
		count_up(&count->excess, 1);
}

#endif
