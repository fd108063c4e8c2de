/* SPDX-License-Identifier: GPL-2.0-only OR BSD-2-Clause */
/* Handles an event that its slot admits: marking, policing, counting, watching. */
#ifndef MLCCA_ETHER_ADMIT_BPF_H
#define MLCCA_ETHER_ADMIT_BPF_H

static __always_inline struct gate_watch *watch_of(const struct ether_slot *slot)
{
	__u32 at = READ_ONCE(slot->watch);

	return at ? bpf_map_lookup_elem(&watches, &at) : NULL;
}

/*
 * Marks an event at ingress, polices, counts and watches it. The clock is read once for all of
 * that. Returns false if it exceeds what was admitted and must be dropped.
 */
static __always_inline bool admit(struct __sk_buff *skb, struct ether_cpu *cpu, __u32 direction,
				  __u32 at, const struct event *e)
{
	struct ether_slot *slot = bpf_map_lookup_elem(&slots, &at);
	const struct ether_contract *contract;
	__u64 cost, period, now = 0;
	struct gate_count *count;
	struct gate_watch *w;

	if (!slot)
		return false;
	contract = contract_of(slot);
	if (!contract)
		return false;
	/* In audit mode, excess goes on with its mark. */
	if (direction == GATE_INGRESS)
		skb->mark = mark_of(slot, contract, ifindex);
	cost = cost_of(contract->per_frame, contract->per_byte, e->len);
	w = watch_of(slot);
	period = w ? READ_ONCE(w->period) : 0;
	if (cost || period)
		now = bpf_ktime_get_ns();
	if (cost && !take_turn(&slot->due, cost, contract->tolerance, now)) {
		if (!(contract->forms & GATE_EXCESS_PASSES))
			return false;
		count = count_of(cpu, at);
		if (count)
			count_up(&count->excess, 1);
	}
	count_pass(cpu, direction, at, e);
	if (w && period)
		watch(w, period, now);
	return true;
}

#endif
