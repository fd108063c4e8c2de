/* SPDX-License-Identifier: GPL-2.0-only OR BSD-2-Clause */
/*
 * The gate of one CAN interface: passes frames that a slot admits, and drops everything else. It
 * passes with TC_ACT_UNSPEC, so that other filters still see the frame. skb.bpf.h or
 * test_skb.bpf.h, which describe a socket buffer, must be included before.
 */
#ifndef MLCCA_GATE_BODY_BPF_H
#define MLCCA_GATE_BODY_BPF_H

#include "bpf/gate.h"
#include "bpf/once.bpf.h"
#include "bpf/shared.bpf.h"
#include "bpf/refuse.bpf.h"

/* These constants are set before loading. */
const volatile __u32 profile = GATE_PROFILE_NONE;
const volatile __u32 ifindex = 0;
/* The device returns what it has sent through ingress, with the mark that egress has set. */
const volatile __u8 echo_by_mark = false;
/* Reads frames by packet pointers; false if the verifier refuses unaligned loads. */
const volatile __u8 direct_access = true;
struct gate_table table; /* the only variable of .bss: this map is pinned and memory-mapped */

struct {
	__uint(type, BPF_MAP_TYPE_ARRAY);
	__uint(map_flags, BPF_F_MMAPABLE);
	__uint(max_entries, 1); /* possible CPUs, set before loading */
	__type(key, __u32);
	__type(value, struct gate_cpu);
} cpus SEC(".maps");

#include "bpf/police.bpf.h"
#include "bpf/sample.bpf.h"
#include "bpf/gate_frame.bpf.h"
#include "bpf/gate_count.bpf.h"
#include "bpf/gate_slot.bpf.h"
#include "bpf/gate_watch.bpf.h"
#include "bpf/gate_tags.bpf.h"

/*
 * Polices a frame. Returns false if it exceeds what was admitted and must be dropped; excess that
 * passes is counted.
 */
static __always_inline bool police(struct gate_cpu *cpu, __u32 at, __u64 cost, __u64 now)
{
	struct gate_slot *slot = &table.slots[at & (GATE_SLOTS - 1)];

	if (!cost || take_turn(&slot->due, cost, READ_ONCE(slot->tolerance), now))
		return true;
	if (!(slot->formats & GATE_EXCESS_PASSES))
		return false;
	add(&cpu->slots[at & (GATE_SLOTS - 1)].excess, 1);
	return true;
}

#include "bpf/gate_transport.bpf.h"

/*
 * Polices, counts and watches a frame that its slot admits. The clock is read once for all of that.
 * Returns false if it exceeds what was admitted and must be dropped.
 */
static __always_inline bool admit(struct gate_cpu *cpu, __u32 direction, __u32 at,
				  const struct frame *frame)
{
	struct gate_slot *slot = &table.slots[at & (GATE_SLOTS - 1)];
	struct gate_watch *w = &table.watches[at & (GATE_SLOTS - 1)];
	__u64 cost = cost_of(READ_ONCE(slot->per_frame), READ_ONCE(slot->per_byte), frame->len),
	      period = READ_ONCE(w->period), now = 0;

	if (gate_has_transport(profile) && frame->transport)
		return admit_transport(cpu, direction, at, frame);
	if (cost || period)
		now = bpf_ktime_get_ns();
	if (!police(cpu, at, cost, now))
		return false;
	count_pass(cpu, direction, at, frame);
	if (period)
		watch(w, period, now);
	return true;
}

static __always_inline struct decision judge(struct __sk_buff *skb, __u32 direction,
					     struct frame *frame)
{
	if (gate_has_transport(profile)) {
		frame->transport = TRANSPORT_NONE;
		if (is_transport(frame))
			return unpacked(judge_transport(skb, frame, direction));
	}
	return decide(skb, direction, frame);
}

SEC("tc")
int gate_ingress(struct __sk_buff *skb)
{
	struct gate_cpu *cpu = this_cpu();
	struct frame frame;
	struct decision d;
	__u32 mark = skb->mark;

	if (!cpu)
		return TC_ACT_SHOT;
	if (is_local(skb) || (echo_by_mark && mark == gate_echo_token(control.token)))
		goto echo;

	skb->mark = 0;
	frame.source = GATE_NO_SOURCE;
	if (!read_frame(skb, GATE_INGRESS, &frame))
		return refuse(skb, cpu, GATE_INGRESS, GATE_INGRESS, GATE_R_MALFORMED, &frame);
	if (frame.can_id & CAN_ERR_FLAG) {
		count_reason(cpu, GATE_INGRESS, GATE_R_ERROR_IN);
		return TC_ACT_UNSPEC;
	}
	if (closed(READ_ONCE(table.epoch))) {
		if (is_reply(&frame))
			heed_reply(skb, &frame, GATE_INGRESS, false);
		return refuse(skb, cpu, GATE_INGRESS, GATE_INGRESS, GATE_R_CLOSED, &frame);
	}

	d = judge(skb, GATE_INGRESS, &frame);
	if (is_reply(&frame))
		heed_reply(skb, &frame, GATE_INGRESS, d.reason == GATE_R_PASSED);
	if (d.reason != GATE_R_PASSED)
		return refuse(skb, cpu, GATE_INGRESS, d.slot, d.reason, &frame);
	/* In audit mode, excess goes on with its mark. */
	skb->mark = gate_ingress_token(control.token, ifindex,
				       table.slots[d.slot & (GATE_SLOTS - 1)].origin);
	if (!admit(cpu, GATE_INGRESS, d.slot, &frame))
		return drop(cpu, GATE_INGRESS, d.slot, GATE_R_EXCESS);
	return TC_ACT_UNSPEC;

echo:
	/* Without a mark, so that it is not forwarded like a frame from the bus. */
	skb->mark = 0;
	count_reason(cpu, GATE_INGRESS, GATE_R_ECHO);
	return TC_ACT_UNSPEC;
}

/* Sets the band, so that the frame that wins arbitration also leaves the queue first. */
static __always_inline void choose_band(struct __sk_buff *skb, __u32 can_id)
{
	__u32 rank = gate_arbitration(can_id), band = 0, i;

	if (!READ_ONCE(table.bands))
		return;
#pragma unroll
	for (i = 0; i < GATE_BANDS - 1; i++)
		band += rank > READ_ONCE(table.band_limit[i]);
	skb->priority = band;
}

/* What audit mode passes is on the bus as well, but it is not a broker's reply. */
static __always_inline int heed_unless_dropped(struct __sk_buff *skb, struct frame *frame,
					       int action)
{
	if (action == TC_ACT_UNSPEC && is_reply(frame))
		heed_reply(skb, frame, GATE_EGRESS, false);
	return action;
}

SEC("tc")
int gate_egress(struct __sk_buff *skb)
{
	struct gate_cpu *cpu = this_cpu();
	struct frame frame;
	struct decision d;

	if (!cpu)
		return TC_ACT_SHOT;
	frame.source = source_of(skb);
	frame.mark = skb->mark;
	/*
	 * No token may leave the machine or the namespace. Local frames get the echo mark as well:
	 * without it, the echo of a program that has closed its socket could not be recognised.
	 */
	skb->mark = echo_by_mark ? gate_echo_token(control.token) : 0;

	if (!read_frame(skb, GATE_EGRESS, &frame))
		return refuse(skb, cpu, GATE_EGRESS, GATE_EGRESS, GATE_R_MALFORMED, &frame);
	if (frame.can_id & CAN_ERR_FLAG)
		return refuse(skb, cpu, GATE_EGRESS, GATE_EGRESS, GATE_R_ERROR_FRAME, &frame);
	if (closed(READ_ONCE(table.epoch)))
		return heed_unless_dropped(
		    skb, &frame, refuse(skb, cpu, GATE_EGRESS, GATE_EGRESS, GATE_R_CLOSED, &frame));

	d = judge(skb, GATE_EGRESS, &frame);
	if (d.reason != GATE_R_PASSED)
		return heed_unless_dropped(skb, &frame,
					   refuse(skb, cpu, GATE_EGRESS, d.slot, d.reason, &frame));
	if (!admit(cpu, GATE_EGRESS, d.slot, &frame))
		return heed_unless_dropped(skb, &frame,
					   drop(cpu, GATE_EGRESS, d.slot, GATE_R_EXCESS));
	if (is_reply(&frame))
		heed_reply(skb, &frame, GATE_EGRESS, true);
	choose_band(skb, frame.can_id);
	return TC_ACT_UNSPEC;
}

#endif
