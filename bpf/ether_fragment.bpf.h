/* SPDX-License-Identifier: GPL-2.0-only OR BSD-2-Clause */
/* Later IP fragments of events: they are treated like the first one. */
#ifndef MLCCA_ETHER_FRAGMENT_BPF_H
#define MLCCA_ETHER_FRAGMENT_BPF_H

#include "bpf/ether_remember.bpf.h"

FRAGMENT_MAP(fragments);

/*
 * Takes the fragment's bytes from what may still follow. If that does not suffice they are given
 * back: for a moment other fragments may find too little, but never too much.
 */
static __always_inline bool take_octets(struct ether_fragment *f, const struct event *e)
{
	if (__sync_fetch_and_add(&f->left, -(__s64)e->payload) >= (__s64)e->payload)
		return true;
	__sync_fetch_and_add(&f->left, (__s64)e->payload);
	return false;
}

/*
 * Whether a later fragment passes: its first fragment was admitted, and would be admitted now from
 * the same sender.
 */
static __always_inline __u32 fragment_reason(const struct ether_fragment *f, const struct event *e)
{
	__u32 end = e->offset + e->payload, at = f->slot;
	const struct ether_slot *slot = bpf_map_lookup_elem(&slots, &at);
	const struct ether_contract *contract;

	if (is_overlaid(f, e) || (e->more ? end >= f->whole : end != f->whole))
		return GATE_R_MALFORMED;
	if (!slot || slot->subject != f->subject || slot->direction != e->key.direction ||
	    verdict_of(slot) != GATE_PASS)
		return GATE_R_DENIED;
	contract = contract_of(slot);
	if (e->key.direction == GATE_EGRESS &&
	    (!contract || !comes_from(contract, e) || !is_vouched_for(slot, contract, e)))
		return GATE_R_SOURCE;
	return GATE_R_PASSED;
}

/*
 * GATE_R_PASSED, or a reason to drop the fragment; GATE_R_FOREIGN if it belongs to no event. Excess
 * is counted with the slot.
 */
static __always_inline struct decision judge_later(struct ether_fragment *f, const struct event *e)
{
	struct decision d = {.slot = e->key.direction, .reason = GATE_R_FRAGMENT};

	if (f) {
		d.reason = closed(READ_ONCE(table.epoch)) ? GATE_R_CLOSED : fragment_reason(f, e);
		if (d.reason == GATE_R_PASSED && !take_octets(f, e)) {
			d.slot = f->slot;
			d.reason = GATE_R_EXCESS;
		}
		return d;
	}
	f = remembered(&foreign_fragments, &e->key);
	if (f)
		d.reason = is_overlaid(f, e) ? GATE_R_MALFORMED : GATE_R_FOREIGN;
	return d;
}

#endif
