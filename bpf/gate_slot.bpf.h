/* SPDX-License-Identifier: GPL-2.0-only OR BSD-2-Clause */
/* The decision: which slot a frame belongs to, and whether that slot admits it. */
#ifndef MLCCA_GATE_SLOT_BPF_H
#define MLCCA_GATE_SLOT_BPF_H

struct decision {
	__u32 slot;
	__u32 reason; /* enum gate_reason */
};

/*
 * A slot's mask covers its key, so that only a misfit needs to know whose key it was. Of a masked
 * slot what the mask covers is the key.
 */
static __always_inline __u32 misfit_identifier(const struct gate_slot *slot, __u32 can_id)
{
	__u32 key = slot->mask & gate_key_mask(profile, slot->id);

	return (slot->id ^ can_id) & key ? GATE_R_UNKNOWN : GATE_R_IDENTIFIER;
}

static __always_inline __u32 fit(struct __sk_buff *skb, __u32 direction,
				 const struct gate_slot *slot, struct frame *frame, __u32 source)
{
	__u32 verdict;

	if ((frame->can_id & slot->mask) != slot->id)
		return misfit_identifier(slot, frame->can_id);
	if (direction == GATE_EGRESS) {
		if (source != slot->source)
			return GATE_R_SOURCE;
		if (source && source != GATE_NO_SOURCE &&
		    frame->mark != gate_ingress_token(control.token, source, slot->origin))
			return GATE_R_SOURCE;
		if (!source && slot->uid != GATE_ANY_UID && slot->uid != bpf_get_socket_uid(skb))
			return GATE_R_SOURCE;
	}
	if (!(slot->formats & frame->format))
		return GATE_R_FORMAT;
	if (frame->len > slot->max_len)
		return GATE_R_LENGTH;
	verdict = READ_ONCE(slot->verdict[frame->generation & 1]);
	frame->read += verdict;
	if (profile == GATE_PROFILE_FAMOUSO && READ_ONCE(slot->contradicted))
		return GATE_R_DENIED;
	return verdict == GATE_PASS ? GATE_R_PASSED : GATE_R_DENIED;
}

/*
 * Not static, like walk(): the verifier looks at it once by itself, and takes its result for any
 * number. Static functions would multiply with every way that leads to and from them.
 */
__noinline __u32 fit_apart(struct __sk_buff *skb, __u32 at, struct frame *frame, __u32 direction,
			   __u32 source)
{
	if (!frame)
		return GATE_R_UNKNOWN;
	return fit(skb, direction, &table.slots[at & (GATE_SLOTS - 1)], frame, source);
}

/*
 * Passes when any slot of the frame's key admits it. Otherwise gives the slot that came furthest,
 * of equals the first; the direction's own slot where the key has none. Reason in the upper half,
 * slot in the lower.
 */
__noinline __u32 walk(struct __sk_buff *skb, __u32 at, struct frame *frame, __u32 direction,
		      __u32 source)
{
	__u32 slot = direction, best = GATE_R_UNKNOWN, i;

	if (!frame)
		return GATE_R_UNKNOWN << 16;
	for (i = 0; i < GATE_WALK && at; i++) {
		__u32 reason = fit_apart(skb, at, frame, direction, source);

		if (reason == GATE_R_PASSED)
			return at;
		if (reason > best) {
			best = reason;
			slot = at;
		}
		at = READ_ONCE(table.slots[at & (GATE_SLOTS - 1)].next);
		frame->read += at;
	}
	return best << 16 | slot;
}

/* As walk(), from the first masked slot. */
static __always_inline __u32 walk_masked(struct __sk_buff *skb, struct frame *frame,
					 __u32 direction, __u32 source)
{
	__u32 first = READ_ONCE(table.masked[direction]);

	frame->read += first;
	return first ? walk(skb, first, frame, direction, source)
		     : GATE_R_UNKNOWN << 16 | direction;
}

/* As walk(), by the verdicts of one generation. */
__noinline __u32 decide_again(struct __sk_buff *skb, const struct frame *frame, __u32 direction,
			      __u32 source)
{
	__u32 bucket, first, found, i;
	struct frame copy;

	if (!frame)
		return GATE_R_UNKNOWN << 16;
	copy = *frame;
	bucket = gate_bucket(profile, copy.can_id);
	direction &= GATE_DIRECTIONS - 1;
	if (bucket >= GATE_BUCKETS)
		return GATE_R_UNKNOWN << 16 | direction;
	for (i = 0; i < GATE_TRIES; i++) {
		copy.generation = READ_ONCE(control.generation);
		copy.read = first = READ_ONCE(table.head[direction][bucket]);
		found = walk(skb, first, &copy, direction, source);
		if (found >> 16 == GATE_R_UNKNOWN)
			found = walk_masked(skb, &copy, direction, source);
		if (!moved_on(copy.generation, copy.read))
			return found;
	}
	return GATE_R_DENIED << 16 | direction;
}

/*
 * The first slot is looked at in place: nearly always it is the only one. A key that has a slot is
 * decided there, even if that refuses: masked slots never open what was refused by name.
 */
static __always_inline struct decision decide(struct __sk_buff *skb, __u32 direction,
					      struct frame *frame, __u32 source)
{
	struct decision d = {.slot = direction, .reason = GATE_R_UNKNOWN};
	__u32 bucket = gate_bucket(profile, frame->can_id);
	const struct gate_slot *slot;
	struct frame copy;
	__u32 first, found;

	if (bucket >= GATE_BUCKETS)
		return d;
	frame->generation = READ_ONCE(control.generation);
	frame->read = first = READ_ONCE(table.head[direction][bucket]);
	found = GATE_R_UNKNOWN << 16 | direction;
	if (first) {
		slot = &table.slots[first & (GATE_SLOTS - 1)];
		d.reason = fit(skb, direction, slot, frame, source);
		if (d.reason != GATE_R_PASSED && READ_ONCE(slot->next)) {
			copy = *frame;
			found = walk(skb, first, &copy, direction, source);
			frame->read += copy.read;
		} else if (d.reason != GATE_R_UNKNOWN) {
			found = d.reason << 16 | first;
		}
	}
	if (found >> 16 == GATE_R_UNKNOWN && READ_ONCE(table.masked[direction])) {
		copy = *frame;
		found = walk_masked(skb, &copy, direction, source);
		frame->read += copy.read;
	}
	if (moved_on(frame->generation, frame->read)) {
		copy = *frame;
		found = decide_again(skb, &copy, direction, source);
	}
	d.reason = found >> 16;
	d.slot = found & 0xffff;
	return d;
}

/* Drops what is not to pass; in audit mode it goes on, marked. Without a slot `frame` is told. */
static __always_inline int refuse_in(struct __sk_buff *skb, struct gate_cpu *cpu, __u32 slot,
				     __u32 reason, const struct frame *frame)
{
	int action;

	if (reason == GATE_R_UNKNOWN)
		note_unknown(cpu, GATE_INGRESS, frame);
	action = drop(cpu, GATE_INGRESS, slot, reason);
	if (action == TC_ACT_UNSPEC)
		skb->mark = gate_refused_token(control.token);
	return action;
}

/* What an ingress gate has refused is counted there, if it comes here all the same. */
static __always_inline int refuse_out(struct gate_cpu *cpu, __u32 slot, __u32 reason,
				      const struct frame *frame)
{
	if (frame->mark == gate_refused_token(control.token) &&
	    READ_ONCE(control.mode) == GATE_AUDIT) {
		count_reason(cpu, GATE_EGRESS, GATE_R_ECHO);
		return TC_ACT_UNSPEC;
	}
	if (reason == GATE_R_UNKNOWN)
		note_unknown(cpu, GATE_EGRESS, frame);
	return drop(cpu, GATE_EGRESS, slot, reason);
}

#endif
