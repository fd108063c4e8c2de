/* SPDX-License-Identifier: GPL-2.0-only OR BSD-2-Clause */
/* Which slot an event belongs to, and whether that slot admits it. */
#ifndef MLCCA_ETHER_DECIDE_BPF_H
#define MLCCA_ETHER_DECIDE_BPF_H

struct decision {
	__u32 slot;
	__u32 reason; /* enum gate_reason */
};

/* Who sends; of no interest at ingress. */
struct sender {
	__u32 source; /* as in gate_frame.bpf.h */
	__u32 uid;    /* of a local program */
};

static __always_inline struct ether_contract *contract_of(const struct ether_slot *slot)
{
	__u32 at = READ_ONCE(slot->contract);

	return bpf_map_lookup_elem(&contracts, &at);
}

/* The mark of what the ingress gate of an interface has passed by a slot like this one. */
static __always_inline __u32 mark_of(const struct ether_slot *slot,
				     const struct ether_contract *contract, __u32 from)
{
	return gate_ingress_token(control.token, from,
				  gate_origin(slot->subject, ether_station(slot, contract)));
}

/* Egress: it comes from the interface of the grant, or from a program of its user. */
static __always_inline bool comes_from(const struct ether_contract *contract,
				       const struct sender *from)
{
	if (from->source != contract->source)
		return false;
	return from->source || contract->uid == GATE_ANY_UID || contract->uid == from->uid;
}

/* Egress: the gate of the interface that it comes from has passed it as what the slot is for. */
static __always_inline bool is_vouched_for(const struct ether_slot *slot,
					   const struct ether_contract *contract, __u32 mark,
					   const struct sender *from)
{
	return !from->source || mark == mark_of(slot, contract, from->source);
}

/*
 * Whoever has a slot of that subject for himself never meets the wildcard. An event that has met
 * its own slot in the chain, which stands first, is `known`.
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

static __always_inline __u32 fit(const struct ether_slot *slot, __u32 direction, struct event *e,
				 const struct sender *from)
{
	const struct ether_contract *contract = contract_of(slot);
	__u32 verdict, reason;

	if (!contract)
		return GATE_R_DENIED;
	if (direction == GATE_EGRESS && !comes_from(contract, from))
		return GATE_R_SOURCE;
	reason = fit_sender(slot, contract, e);
	if (reason != GATE_R_PASSED)
		return reason;
	if (direction == GATE_EGRESS && !is_vouched_for(slot, contract, e->mark, from))
		return GATE_R_SOURCE;
	if (!(contract->forms & e->form))
		return GATE_R_FORMAT;
	if (e->len > contract->max_len)
		return GATE_R_LENGTH;
	verdict = READ_ONCE(slot->verdict[e->generation & 1]);
	e->read += verdict;
	return verdict == GATE_PASS ? GATE_R_PASSED : GATE_R_DENIED;
}

static __always_inline bool is_of(const struct ether_slot *slot, __u32 direction,
				  const struct event *e)
{
	return slot->subject == e->subject && slot->direction == direction;
}

/*
 * Not static, like walk(): the verifier looks at it once by itself, and takes its result for any
 * number. Static functions would multiply with every way that leads to and from them.
 */
__noinline __u32 fit_apart(__u32 at, __u32 direction, struct event *e, const struct sender *from)
{
	const struct ether_slot *slot = bpf_map_lookup_elem(&slots, &at);

	if (!slot || !e || !from || !is_of(slot, direction, e))
		return GATE_R_UNKNOWN;
	return fit(slot, direction, e, from);
}

/*
 * Passes when any slot of the subject admits the event. Otherwise gives the slot that came
 * furthest, of equals the first; the direction's own slot where the subject has none. Reason in the
 * upper half of the word, slot in the lower.
 */
__noinline __u64 walk(__u32 at, struct event *e, __u32 direction, const struct sender *from)
{
	__u64 slot = direction, best = GATE_R_UNKNOWN;
	__u32 i;

	if (!e)
		return best << 32 | slot;
	for (i = 0; i < GATE_WALK && at; i++) {
		const struct ether_slot *s;
		__u32 reason = fit_apart(at, direction, e, from);

		if (reason == GATE_R_PASSED)
			return at;
		if (reason > best) {
			best = reason;
			slot = at;
		}
		s = bpf_map_lookup_elem(&slots, &at);
		if (!s)
			break;
		at = READ_ONCE(s->next);
		e->read += at;
	}
	return best << 32 | slot;
}

/* As walk(), by the verdicts of one generation. */
__noinline __u64 decide_again(const struct event *e, __u32 direction, const struct sender *from)
{
	__u64 *bucket, hash, found;
	struct event copy;
	__u32 at, first, i;

	direction &= GATE_DIRECTIONS - 1;
	if (!e)
		return (__u64)GATE_R_UNKNOWN << 32 | direction;
	copy = *e;
	hash = ether_hash(table.seed, copy.subject, direction);
	at = hash & bucket_mask;
	bucket = bpf_map_lookup_elem(&buckets, &at);
	if (!bucket)
		return (__u64)GATE_R_UNKNOWN << 32 | direction;
	for (i = 0; i < GATE_TRIES; i++) {
		copy.generation = READ_ONCE(control.generation);
		copy.read = first = READ_ONCE(*bucket);
		found = walk(first, &copy, direction, from);
		if (!moved_on(copy.generation, copy.read))
			return found;
	}
	return (__u64)GATE_R_DENIED << 32 | direction;
}

/* Of one slot, by one generation. */
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

/* False: the bucket has no such subject. Bits are there before their subject, and go after it. */
static __always_inline bool may_be_there(__u32 bucket, __u64 hash)
{
	__u32 at = bucket / ETHER_PREFILTER_BUCKETS;
	const struct ether_prefilter_part *part = bpf_map_lookup_elem(&ether_prefilter, &at);
	__u8 wanted = ether_prefilter_bits(hash);

	return part && (READ_ONCE(part->bits[bucket % ETHER_PREFILTER_BUCKETS]) & wanted) == wanted;
}

/* The first slot is looked at in place: nearly always it is the only one. */
static __always_inline struct decision decide(__u32 direction, struct event *e,
					      const struct sender *from)
{
	struct decision d = {.slot = direction, .reason = GATE_R_UNKNOWN};
	__u64 hash = ether_hash(table.seed, e->subject, direction);
	__u32 at = hash & bucket_mask, first;
	__u64 *bucket, found;
	const struct ether_slot *slot;
	struct sender from_copy;
	struct event copy;

	if (has_prefilter && !may_be_there(at, hash))
		return d;
	bucket = bpf_map_lookup_elem(&buckets, &at);
	if (!bucket)
		return d;
	e->generation = READ_ONCE(control.generation);
	found = READ_ONCE(*bucket);
	if (!(found & ether_fingerprint(hash)))
		return d;
	e->read = first = found;
	slot = bpf_map_lookup_elem(&slots, &first);
	if (!slot)
		return d;
	if (is_of(slot, direction, e)) {
		d.slot = first;
		d.reason = fit(slot, direction, e, from);
	}
	if (d.reason != GATE_R_PASSED && READ_ONCE(slot->next)) {
		copy = *e;
		from_copy = *from;
		found = walk(first, &copy, direction, &from_copy);
		e->read += copy.read;
		d.reason = found >> 32;
		d.slot = found;
	}
	if (moved_on(e->generation, e->read)) {
		copy = *e;
		from_copy = *from;
		found = decide_again(&copy, direction, &from_copy);
		d.reason = found >> 32;
		d.slot = found;
	}
	return d;
}

#endif
