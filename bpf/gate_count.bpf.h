/* SPDX-License-Identifier: GPL-2.0-only OR BSD-2-Clause */
/*
 * Exact counters for CAN. A CPU writes only its own gate_cpu. tc programs run with bottom halves
 * disabled, from a system call or a softirq, and never nest: a frame that ingress passes reaches
 * egress only after the ingress program has returned. So plain additions lose nothing. Under
 * PREEMPT_RT, bottom halves can be preempted; `atomic_counts` is set there.
 */
#ifndef MLCCA_GATE_COUNT_BPF_H
#define MLCCA_GATE_COUNT_BPF_H

#define CPU	gate_cpu
#define SEEN	gate_seen
#define ARRIVED frame
#include "bpf/count.bpf.h"

static __always_inline struct gate_count *count_of(struct gate_cpu *cpu, __u32 slot)
{
	return &cpu->slots[slot & (GATE_SLOTS - 1)];
}

static __always_inline void count_up(__u64 *counter, __u64 n) { add(counter, n); }

static __always_inline struct gate_audit *audit_of(__u32 slot)
{
	return &table.audit[slot & (GATE_SLOTS - 1)];
}

static __always_inline void set_last_reason(__u32 slot, __u32 reason)
{
	table.last_reason[slot & (GATE_SLOTS - 1)] = reason;
}

static __always_inline __u32 octets_of(const struct frame *frame)
{
	return frame->can_id & CAN_RTR_FLAG ? 0 : frame->len;
}

static __always_inline __u32 seen_hash(const struct frame *frame, __u32 direction)
{
	return ((frame->can_id + direction) * 0x9e3779b1U) >> 16;
}

static __always_inline bool is_same(const struct gate_seen *seen, const struct frame *frame)
{
	return seen->can_id == frame->can_id && seen->format == frame->format;
}

static __always_inline void keep_same(struct gate_seen *seen, const struct frame *frame)
{
	seen->can_id = frame->can_id;
	seen->format = frame->format;
}

static __always_inline void keep_latest(struct gate_seen *seen, const struct frame *frame)
{
	seen->len = frame->len;
}

static __always_inline void describe(struct gate_sample *sample, const struct frame *frame)
{
	sample->can_id = frame->can_id;
	sample->len = frame->len;
	sample->format = frame->format;
}

static __always_inline bool is_sender(const struct gate_sender *there,
				      const struct gate_sender *who)
{
	return there->sequence && there->can_id == who->can_id && there->slot == who->slot &&
	       there->source == who->source && there->uid == who->uid &&
	       there->format == who->format && there->direction == who->direction &&
	       there->reason == who->reason;
}

static __always_inline __u32 sender_set(const struct gate_sender *who)
{
	return gate_sender_set((__u64)who->slot << 32 | who->can_id,
			       (__u64)who->source << 32 | who->uid);
}

#define SENDER gate_sender
#include "bpf/senders.bpf.h"

/*
 * Whether reports state who has sent what is refused for this reason. A closed gate refuses
 * everything, so that it says nothing about a sender.
 */
static __always_inline bool names_sender(__u32 slot, __u32 reason)
{
	if (slot < GATE_FIRST_SLOT)
		return reason != GATE_R_UNKNOWN && reason != GATE_R_CLOSED;
	return reason == GATE_R_IDENTIFIER || reason == GATE_R_SOURCE;
}

static __always_inline void note_refusal(struct __sk_buff *skb, struct gate_cpu *cpu,
					 __u32 direction, __u32 slot, __u32 reason,
					 struct frame *frame)
{
	if (reason == GATE_R_UNKNOWN)
		note_unknown(cpu, direction, frame);
	if (names_sender(slot, reason)) {
		__u32 all = skb->len;
		struct gate_sender who = {
		    .can_id = frame->can_id,
		    .source = frame->source,
		    .uid = frame->source ? GATE_ANY_UID : bpf_get_socket_uid(skb),
		    .slot = slot,
		    .len = frame->len,
		    .format = frame->format,
		    .direction = direction,
		    .reason = reason,
		};

		/* The verifier refuses one load from either pointer. */
		asm volatile("" : "+r"(all));
		if (reason == GATE_R_MALFORMED)
			who.len = all;
		note_sender(&who);
	}
}

#endif
