/* SPDX-License-Identifier: GPL-2.0-only OR BSD-2-Clause */
/*
 * Exact counters for Ethernet, like gate_count.bpf.h. If a table has one bank of counters for all
 * CPUs, they are updated atomically.
 */
#ifndef MLCCA_ETHER_COUNT_BPF_H
#define MLCCA_ETHER_COUNT_BPF_H

#define CPU	ether_cpu
#define SEEN	ether_seen
#define ARRIVED event
#include "bpf/count.bpf.h"

static __always_inline struct gate_count *count_of(struct ether_cpu *cpu, __u32 slot)
{
	__u32 at = banks == 1 ? slot : bpf_get_smp_processor_id() * slots_of_bank + slot;

	(void)cpu;
	return bpf_map_lookup_elem(&counts, &at);
}

static __always_inline void count_up(__u64 *counter, __u64 n)
{
	if (banks == 1)
		add_atomic(counter, n);
	else
		add(counter, n);
}

static __always_inline struct gate_audit *audit_of(__u32 slot)
{
	return bpf_map_lookup_elem(&audits, &slot);
}

static __always_inline void set_last_reason(__u32 at, __u32 reason)
{
	struct ether_slot *slot = bpf_map_lookup_elem(&slots, &at);

	if (slot)
		slot->last_reason = reason;
}

static __always_inline __u32 octets_of(const struct event *e) { return e->len; }

static __always_inline __u32 seen_hash(const struct event *e, __u32 direction)
{
	return ether_hash(0, e->subject, direction);
}

static __always_inline bool is_same(const struct ether_seen *seen, const struct event *e)
{
	return seen->subject == e->subject;
}

static __always_inline void keep_same(struct ether_seen *seen, const struct event *e)
{
	seen->subject = e->subject;
}

static __always_inline void keep_latest(struct ether_seen *seen, const struct event *e)
{
	seen->len = e->len;
	seen->station = e->station;
	__builtin_memcpy(seen->mac, e->mac, sizeof(seen->mac));
}

static __always_inline void describe(struct gate_sample *sample, const struct event *e)
{
	sample->subject = e->subject;
	sample->len = e->len;
	sample->station = e->station;
	__builtin_memcpy(sample->mac, e->mac, sizeof(sample->mac));
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

/* Whether a refused sender is kept, see names_sender() of CAN. */
static __always_inline bool keeps_sender(__u32 slot, __u32 reason)
{
	if (slot < ETHER_FIRST_SLOT)
		return reason != GATE_R_UNKNOWN && reason != GATE_R_CLOSED;
	return reason == GATE_R_SOURCE;
}

/* Whether reports state who has sent what is refused for this reason. */
static __always_inline bool names_sender(__u32 slot, __u32 reason)
{
	return reason == GATE_R_UNKNOWN || keeps_sender(slot, reason);
}

/* Like note_refusal(), once the address of the sender is read. */
static __always_inline void note_event(struct ether_cpu *cpu, __u32 direction, __u32 at,
				       __u32 reason, const struct event *e)
{
	if (reason == GATE_R_UNKNOWN)
		note_unknown(cpu, direction, e);
	if (keeps_sender(at, reason)) {
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
}

#endif
