/* SPDX-License-Identifier: GPL-2.0-only OR BSD-2-Clause */
/*
 * The counting that gates of CAN and of Ethernet have in common: what passes, what is dropped or in
 * audit mode would be, and what has no slot. A kind of gate defines before it is included:
 *   CPU       the struct of the counters of one CPU, with the members `reasons` and `seen`
 *   SEEN      the struct of an entry of `seen`, with the members `sequence` and `count`
 *   ARRIVED   the struct of what has arrived, with the member `mark`
 * and after it the functions that are declared here.
 */
#ifndef MLCCA_COUNT_BPF_H
#define MLCCA_COUNT_BPF_H

/* The counters of a slot. May be NULL, like the result of audit_of(). */
static __always_inline struct gate_count *count_of(struct CPU *cpu, __u32 slot);
static __always_inline void count_up(__u64 *counter, __u64 n);
static __always_inline struct gate_audit *audit_of(__u32 slot);
static __always_inline void set_last_reason(__u32 slot, __u32 reason);
/* The payload bytes that are counted. */
static __always_inline __u32 octets_of(const struct ARRIVED *one);
/* Selects the entry of `seen`. */
static __always_inline __u32 seen_hash(const struct ARRIVED *one, __u32 direction);
/* Whether an entry is of the same kind; keep_same() makes it so. */
static __always_inline bool is_same(const struct SEEN *seen, const struct ARRIVED *one);
static __always_inline void keep_same(struct SEEN *seen, const struct ARRIVED *one);
/* Keeps what the entry states of the latest one. */
static __always_inline void keep_latest(struct SEEN *seen, const struct ARRIVED *one);
static __always_inline void describe(struct gate_sample *sample, const struct ARRIVED *one);
/* Notes what is refused, or who has sent it, if that is the reason. */
static __always_inline void note_refusal(struct __sk_buff *skb, struct CPU *cpu, __u32 direction,
					 __u32 slot, __u32 reason, struct ARRIVED *one);

static __always_inline struct CPU *this_cpu(void)
{
	__u32 key = bpf_get_smp_processor_id();

	return bpf_map_lookup_elem(&cpus, &key);
}

static __always_inline void count_reason(struct CPU *cpu, __u32 direction, __u32 reason)
{
	add(&cpu->reasons[direction][reason & (GATE_REASONS - 1)], 1);
}

static __always_inline void count_pass(struct CPU *cpu, __u32 direction, __u32 slot,
				       const struct ARRIVED *one)
{
	struct gate_count *count = count_of(cpu, slot);

	if (count) {
		count_up(&count->passed, 1);
		count_up(&count->bytes, octets_of(one));
	}
	count_reason(cpu, direction, GATE_R_PASSED);
}

/*
 * Whether nothing is dropped: in audit mode, and when the interface was removed from the gateway.
 */
static __always_inline bool lets_all_through(void)
{
	return READ_ONCE(control.mode) == GATE_AUDIT || READ_ONCE(table.retired);
}

static __always_inline void count_would_drop(__u32 direction, __u32 slot, __u32 reason)
{
	struct gate_audit *audit = audit_of(slot);

	if (audit) {
		add_atomic(&audit->would_drop, 1);
		if (reason == GATE_R_EXCESS)
			add_atomic(&audit->would_exceed, 1);
	}
	add_atomic(&table.would_drop[direction][reason & (GATE_REASONS - 1)], 1);
}

static __always_inline void count_drop(struct CPU *cpu, __u32 direction, __u32 slot, __u32 reason)
{
	struct gate_count *count = count_of(cpu, slot);

	if (count) {
		count_up(&count->dropped, 1);
		if (reason == GATE_R_EXCESS)
			count_up(&count->excess, 1);
	}
	count_reason(cpu, direction, reason);
}

/* Counts a drop, or what would be one, and returns the action. */
static __always_inline int drop(struct CPU *cpu, __u32 direction, __u32 slot, __u32 reason)
{
	set_last_reason(slot, reason);
	if (lets_all_through()) {
		count_would_drop(direction, slot, reason);
		return TC_ACT_UNSPEC;
	}
	count_drop(cpu, direction, slot, reason);
	return refusal(direction);
}

/*
 * Drops what no slot admits. In audit mode, what ingress refuses goes on with a mark, so that it is
 * counted once: egress passes it without counting it again.
 */
static __always_inline int refuse(struct __sk_buff *skb, struct CPU *cpu, __u32 direction,
				  __u32 slot, __u32 reason, struct ARRIVED *one)
{
	int action;

	if (direction == GATE_EGRESS && one->mark == gate_refused_token(control.token) &&
	    READ_ONCE(control.mode) == GATE_AUDIT) {
		count_reason(cpu, GATE_EGRESS, GATE_R_ECHO);
		return TC_ACT_UNSPEC;
	}
	note_refusal(skb, cpu, direction, slot, reason, one);
	action = drop(cpu, direction, slot, reason);
	if (direction == GATE_INGRESS && action == TC_ACT_UNSPEC)
		skb->mark = gate_refused_token(control.token);
	return action;
}

static __always_inline void report_unknown(__u64 frames, __u32 direction, const struct ARRIVED *one)
{
	struct gate_sample sample = {
	    .ifindex = ifindex,
	    .frames = frames,
	    .direction = direction,
	    .audit = lets_all_through(),
	};

	describe(&sample, one);
	report_sample(&sample, &table.sample_due);
}

/* The sequence is 0 while the entry is reused for another kind. */
static __always_inline void note_unknown(struct CPU *cpu, __u32 direction,
					 const struct ARRIVED *one)
{
	struct SEEN *seen = &cpu->seen[seen_hash(one, direction) & (GATE_SEEN - 1)];
	__u64 sequence = __sync_fetch_and_add(&table.unknown_frames, 1) + 1;

	if (!seen->sequence || !is_same(seen, one) || seen->direction != direction) {
		store_in_order(&seen->sequence, 0);
		keep_same(seen, one);
		seen->direction = direction;
		seen->count = 0;
		report_unknown(sequence, direction, one);
	}
	keep_latest(seen, one);
	seen->count++;
	store_in_order(&seen->sequence, sequence);
}

#endif
