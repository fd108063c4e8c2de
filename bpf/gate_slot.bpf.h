/* SPDX-License-Identifier: GPL-2.0-only OR BSD-2-Clause */
/* Decides which slot a frame belongs to, and whether the slot admits it. */
#ifndef MLCCA_GATE_SLOT_BPF_H
#define MLCCA_GATE_SLOT_BPF_H

#define ASKED	   frame
#define CONTEXT	   struct __sk_buff *skb,
#define OF_CONTEXT skb,
#include "bpf/decide.bpf.h"

/* Whether a J1939 frame has another destination than the one that the slot states. */
static __always_inline bool is_elsewhere(const struct gate_slot *slot, __u32 can_id)
{
	return gate_has_destinations(profile) &&
	       ((slot->id ^ can_id) & slot->mask & GATE_TP_DESTINATION);
}

/*
 * The reason for an identifier that does not fit. A slot's mask covers its key, so only such a
 * frame needs to know whether the key was the slot's. For a masked slot, the part that the mask
 * covers is the key. A frame with another destination is none of the slot's subject. Only a
 * transported message keeps the slot then, because without one it would be control traffic.
 */
static __always_inline __u32 misfit_identifier(const struct gate_slot *slot,
					       const struct frame *frame)
{
	__u32 key = slot->mask & gate_key_mask(profile, slot->id);

	if ((slot->id ^ frame->can_id) & key)
		return GATE_R_UNKNOWN;
	return frame->format != GATE_TRANSPORT && is_elsewhere(slot, frame->can_id)
		   ? GATE_R_UNKNOWN
		   : GATE_R_IDENTIFIER;
}

static __always_inline __u32 fit(struct __sk_buff *skb, __u32 direction,
				 const struct gate_slot *slot, struct frame *frame)
{
	__u32 source = frame->source, reason;

	if ((frame->can_id & slot->mask) != slot->id)
		return misfit_identifier(slot, frame);
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
	reason = reason_of_verdict(slot->verdict, frame);
	if (gate_has_broker(profile) && READ_ONCE(slot->contradicted))
		return GATE_R_DENIED;
	return reason;
}

/* Not static, for the same reason as walk(). */
__noinline __u32 fit_apart(struct __sk_buff *skb, __u32 at, struct frame *frame, __u32 direction)
{
	if (!frame)
		return GATE_R_UNKNOWN;
	return fit(skb, direction, &table.slots[at & (GATE_SLOTS - 1)], frame);
}

static __always_inline __u32 next_of(__u32 at)
{
	return READ_ONCE(table.slots[at & (GATE_SLOTS - 1)].next);
}

/* Like walk(), from the first masked slot. */
static __always_inline __u64 walk_masked(struct __sk_buff *skb, struct frame *frame,
					 __u32 direction)
{
	__u32 first = READ_ONCE(table.masked[direction]);

	frame->read += first;
	return first ? walk(skb, first, frame, direction) : packed(GATE_R_UNKNOWN, direction);
}

static __always_inline __u64 walk_from_head(struct __sk_buff *skb, struct frame *frame,
					    __u32 direction)
{
	__u32 bucket = gate_bucket(profile, frame->can_id), first;
	__u64 found;

	if (bucket >= GATE_BUCKETS)
		return packed(GATE_R_UNKNOWN, direction);
	first = READ_ONCE(table.head[direction][bucket]);
	frame->read += first;
	found = walk(skb, first, frame, direction);
	return found >> 32 == GATE_R_UNKNOWN ? walk_masked(skb, frame, direction) : found;
}

/*
 * The first slot is compared in place, because it is nearly always the only one. A key that has a
 * slot is decided by it, even if that refuses: a masked slot never admits what was refused by name.
 */
static __always_inline struct decision decide(struct __sk_buff *skb, __u32 direction,
					      struct frame *frame)
{
	__u32 bucket = gate_bucket(profile, frame->can_id), first, reason;
	__u64 found = packed(GATE_R_UNKNOWN, direction);
	const struct gate_slot *slot;
	struct frame copy;

	if (bucket >= GATE_BUCKETS)
		return unpacked(found);
	frame->generation = READ_ONCE(control.generation);
	frame->read = first = READ_ONCE(table.head[direction][bucket]);
	if (first) {
		slot = &table.slots[first & (GATE_SLOTS - 1)];
		reason = fit(skb, direction, slot, frame);
		if (reason != GATE_R_PASSED && READ_ONCE(slot->next)) {
			copy = *frame;
			found = walk(skb, first, &copy, direction);
			frame->read += copy.read;
		} else if (reason != GATE_R_UNKNOWN) {
			found = packed(reason, first);
		}
	}
	if (found >> 32 == GATE_R_UNKNOWN && READ_ONCE(table.masked[direction])) {
		copy = *frame;
		found = walk_masked(skb, &copy, direction);
		frame->read += copy.read;
	}
	return settled(skb, frame, direction, found);
}

#endif
