/* SPDX-License-Identifier: GPL-2.0-only OR BSD-2-Clause */
/* Decides which slot an event belongs to, and whether the slot admits it. */
#ifndef MLCCA_ETHER_DECIDE_BPF_H
#define MLCCA_ETHER_DECIDE_BPF_H

#define ASKED event
#define CONTEXT
#define OF_CONTEXT
#include "bpf/decide.bpf.h"

static __always_inline struct ether_contract *contract_of(const struct ether_slot *slot)
{
	__u32 at = READ_ONCE(slot->contract);

	return bpf_map_lookup_elem(&contracts, &at);
}

/* The mark of events that the ingress gate of interface `from` has passed by such a slot. */
static __always_inline __u32 mark_of(const struct ether_slot *slot,
				     const struct ether_contract *contract, __u32 from)
{
	return gate_ingress_token(control.token, from,
				  gate_origin(slot->subject, ether_station(slot, contract)));
}

/*
 * Egress: whether the event comes from the granted interface, or from a program of the granted
 * user.
 */
static __always_inline bool comes_from(const struct ether_contract *contract, const struct event *e)
{
	if (e->source != contract->source)
		return false;
	return e->source || contract->uid == GATE_ANY_UID || contract->uid == e->uid;
}

/*
 * Egress: whether the gate of the interface that it comes from has passed it as this slot's event.
 */
static __always_inline bool is_vouched_for(const struct ether_slot *slot,
					   const struct ether_contract *contract,
					   const struct event *e)
{
	return !e->source || e->mark == mark_of(slot, contract, e->source);
}

/*
 * Checks the sender. A station with a slot of its own for the subject never uses the wildcard
 * entry: its slot precedes that in the chain and sets `known`.
 */
static __always_inline __u32 fit_sender(const struct ether_slot *slot,
					const struct ether_contract *contract, struct event *e)
{
	__u64 station = ether_station(slot, contract);

	if (!station)
		return e->known ? GATE_R_UNKNOWN : GATE_R_PASSED;
	if (station != e->station)
		return GATE_R_SOURCE;
	e->known = true;
	return GATE_R_PASSED;
}

static __always_inline __u32 fit(const struct ether_slot *slot, __u32 direction, struct event *e)
{
	const struct ether_contract *contract = contract_of(slot);
	__u32 reason;

	if (!contract)
		return GATE_R_DENIED;
	if (direction == GATE_EGRESS && !comes_from(contract, e))
		return GATE_R_SOURCE;
	reason = fit_sender(slot, contract, e);
	if (reason != GATE_R_PASSED)
		return reason;
	if (direction == GATE_EGRESS && !is_vouched_for(slot, contract, e))
		return GATE_R_SOURCE;
	if (!(contract->forms & e->form))
		return GATE_R_FORMAT;
	if (e->len > contract->max_len)
		return GATE_R_LENGTH;
	return reason_of_verdict(slot->verdict, e);
}

static __always_inline bool is_of(const struct ether_slot *slot, __u32 direction,
				  const struct event *e)
{
	return slot->subject == e->subject && slot->direction == direction;
}

/* Not static, for the same reason as walk(). */
__noinline __u32 fit_apart(__u32 at, struct event *e, __u32 direction)
{
	const struct ether_slot *slot = bpf_map_lookup_elem(&slots, &at);

	if (!slot || !e || !is_of(slot, direction, e))
		return GATE_R_UNKNOWN;
	return fit(slot, direction, e);
}

static __always_inline __u32 next_of(__u32 at)
{
	const struct ether_slot *slot = bpf_map_lookup_elem(&slots, &at);

	return slot ? READ_ONCE(slot->next) : 0;
}

static __always_inline __u64 walk_from_head(struct event *e, __u32 direction)
{
	__u64 hash = ether_hash(table.seed, e->subject, direction);
	__u32 at = hash & bucket_mask, first;
	__u64 *bucket = bpf_map_lookup_elem(&buckets, &at);

	if (!bucket)
		return packed(GATE_R_UNKNOWN, direction);
	first = READ_ONCE(*bucket);
	e->read += first;
	return walk(first, e, direction);
}

/* The verdict of one slot, read in one generation. */
static __always_inline __u32 verdict_of(const struct ether_slot *slot)
{
	__u32 i;

	for (i = 0; i < GATE_TRIES; i++) {
		__u32 generation = READ_ONCE(control.generation);
		__u32 verdict = READ_ONCE(slot->verdict[generation & 1]);

		if (!moved_on(generation, verdict))
			return verdict;
	}
	return GATE_DENY;
}

/*
 * Returns false if the bucket has no such subject. User space sets the bits before it adds a
 * subject, and clears them after it has removed it.
 */
static __always_inline bool may_be_there(__u32 bucket, __u64 hash)
{
	__u32 at = bucket / ETHER_PREFILTER_BUCKETS;
	const struct ether_prefilter_part *part = bpf_map_lookup_elem(&ether_prefilter, &at);
	__u8 wanted = ether_prefilter_bits(hash);

	return part && (READ_ONCE(part->bits[bucket % ETHER_PREFILTER_BUCKETS]) & wanted) == wanted;
}

/* The first slot is compared in place, because it is nearly always the only one. */
static __always_inline struct decision decide(__u32 direction, struct event *e)
{
	__u64 hash = ether_hash(table.seed, e->subject, direction);
	__u64 *bucket, head, found = packed(GATE_R_UNKNOWN, direction);
	__u32 at = hash & bucket_mask, first, reason = GATE_R_UNKNOWN;
	const struct ether_slot *slot;
	struct event copy;

	if (has_prefilter && !may_be_there(at, hash))
		return unpacked(found);
	bucket = bpf_map_lookup_elem(&buckets, &at);
	if (!bucket)
		return unpacked(found);
	e->generation = READ_ONCE(control.generation);
	head = READ_ONCE(*bucket);
	if (!(head & ether_fingerprint(hash)))
		return unpacked(found);
	e->read = first = head;
	slot = bpf_map_lookup_elem(&slots, &first);
	if (!slot)
		return unpacked(found);
	if (is_of(slot, direction, e)) {
		reason = fit(slot, direction, e);
		found = packed(reason, first);
	}
	if (reason != GATE_R_PASSED && READ_ONCE(slot->next)) {
		copy = *e;
		found = walk(first, &copy, direction);
		e->read += copy.read;
	}
	return settled(e, direction, found);
}

#endif
