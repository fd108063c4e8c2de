/* SPDX-License-Identifier: GPL-2.0-only OR BSD-2-Clause */
/*
 * Keeps who sends in place of a granted sender, or what has not the form of an event, in the table
 * of this CPU. Gates of CAN and of Ethernet have it in common. A kind of gate defines before it is
 * included:
 *   SENDER         the struct of a sender, with the members `sequence`, `count` and `len`
 *   is_sender()    whether an entry is of this sender
 *   sender_set()   the set that the sender belongs to
 */
#ifndef MLCCA_SENDERS_BPF_H
#define MLCCA_SENDERS_BPF_H

/*
 * Counts a frame of a sender that a slot refused; `sequence` and `count` of `who` must be 0. The
 * sequence of an entry is 0 while it is reused for another sender. It is not static, so that the
 * verifier checks it once.
 */
__noinline __u32 note_sender(const struct SENDER *who)
{
	typeof(this_cpu()) cpu = this_cpu();
	struct SENDER *there = NULL;
	__u64 sequence, quiet = ~0ULL;
	__u32 first, i;

	if (!who || !cpu)
		return 0;
	first = GATE_SENDER_WAYS * sender_set(who);
	for (i = 0; i < GATE_SENDER_WAYS; i++) {
		struct SENDER *one = &cpu->senders[(first + i) & (GATE_SENDERS - 1)];

		if (is_sender(one, who)) {
			there = one;
			break;
		}
		if (one->sequence < quiet) {
			quiet = one->sequence;
			there = one;
		}
	}
	if (!there)
		return 0;
	sequence = __sync_fetch_and_add(&table.refused_senders, 1) + 1;
	if (!is_sender(there, who)) {
		store_in_order(&there->sequence, 0);
		*there = *who;
	}
	there->len = who->len;
	there->count++;
	store_in_order(&there->sequence, sequence);
	return 0;
}

#endif
