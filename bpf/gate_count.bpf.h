/* SPDX-License-Identifier: GPL-2.0-only OR BSD-2-Clause */
/*
 * Exact counters for CAN. A CPU writes only its own gate_cpu. tc programs run with bottom halves
 * disabled, from a system call or a softirq, and never nest: a frame that ingress passes reaches
 * egress only after the ingress program has returned. So plain additions lose nothing. Under
 * PREEMPT_RT, bottom halves can be preempted; `atomic_counts` is set there.
 */
#ifndef MLCCA_GATE_COUNT_BPF_H
#define MLCCA_GATE_COUNT_BPF_H

static __always_inline struct gate_cpu *this_cpu(void)
{
	__u32 key = bpf_get_smp_processor_id();

	return bpf_map_lookup_elem(&cpus, &key);
}

static __always_inline void count_reason(struct gate_cpu *cpu, __u32 direction, __u32 reason)
{
	add(&cpu->reasons[direction][reason & (GATE_REASONS - 1)], 1);
}

static __always_inline void count_pass(struct gate_cpu *cpu, __u32 direction, __u32 slot,
				       const struct frame *frame)
{
	struct gate_count *count = &cpu->slots[slot & (GATE_SLOTS - 1)];

	add(&count->passed, 1);
	add(&count->bytes, frame->can_id & CAN_RTR_FLAG ? 0 : frame->len);
	count_reason(cpu, direction, GATE_R_PASSED);
}

/*
 * Whether nothing is dropped: in audit mode, and when the interface was removed from the gateway.
 */
static __always_inline bool lets_all_through(void)
{
	return READ_ONCE(control.mode) == GATE_AUDIT || READ_ONCE(table.retired);
}

static __always_inline int count_would_drop(__u32 direction, __u32 slot, __u32 reason)
{
	struct gate_audit *audit = &table.audit[slot & (GATE_SLOTS - 1)];

	add_atomic(&audit->would_drop, 1);
	if (reason == GATE_R_EXCESS)
		add_atomic(&audit->would_exceed, 1);
	add_atomic(&table.would_drop[direction][reason & (GATE_REASONS - 1)], 1);
	return TC_ACT_UNSPEC;
}

/* Counts a drop, or what would be one, and returns the action. */
static __always_inline int drop(struct gate_cpu *cpu, __u32 direction, __u32 slot, __u32 reason)
{
	slot &= GATE_SLOTS - 1;
	table.last_reason[slot] = reason;
	if (lets_all_through())
		return count_would_drop(direction, slot, reason);
	add(&cpu->slots[slot].dropped, 1);
	if (reason == GATE_R_EXCESS)
		add(&cpu->slots[slot].excess, 1);
	count_reason(cpu, direction, reason);
	return refusal(direction);
}

static __always_inline void report_unknown(__u64 frames, __u32 direction, const struct frame *frame)
{
	struct gate_sample sample = {
	    .ifindex = ifindex,
	    .frames = frames,
	    .can_id = frame->can_id,
	    .len = frame->len,
	    .format = frame->format,
	    .direction = direction,
	    .audit = lets_all_through(),
	};

	report_sample(&sample, &table.sample_due);
}

/* The sequence is 0 while the entry is reused for another frame. */
static __always_inline void note_unknown(struct gate_cpu *cpu, __u32 direction,
					 const struct frame *frame)
{
	__u32 at = ((frame->can_id + direction) * 0x9e3779b1U) >> 16;
	struct gate_seen *seen = &cpu->seen[at & (GATE_SEEN - 1)];
	__u64 sequence = __sync_fetch_and_add(&table.unknown_frames, 1) + 1;

	if (!seen->sequence || seen->can_id != frame->can_id || seen->format != frame->format ||
	    seen->direction != direction) {
		store_in_order(&seen->sequence, 0);
		seen->can_id = frame->can_id;
		seen->format = frame->format;
		seen->direction = direction;
		seen->count = 0;
		report_unknown(sequence, direction, frame);
	}
	seen->len = frame->len;
	seen->count++;
	store_in_order(&seen->sequence, sequence);
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

/* Notes what kind of frame is refused, or who has sent it, if that is the reason. */
static __always_inline void note_refusal(struct __sk_buff *skb, struct gate_cpu *cpu,
					 __u32 direction, __u32 slot, __u32 reason,
					 const struct frame *frame)
{
	if (reason == GATE_R_UNKNOWN)
		note_unknown(cpu, direction, frame);
	if ((reason == GATE_R_IDENTIFIER || reason == GATE_R_SOURCE) && slot >= GATE_FIRST_SLOT) {
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

		note_sender(&who);
	}
}

#endif
