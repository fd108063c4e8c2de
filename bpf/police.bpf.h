/* SPDX-License-Identifier: GPL-2.0-only OR BSD-2-Clause */
/* The generic cell rate algorithm (ITU-T I.371, virtual scheduling), see struct gate_slot. */
#ifndef MLCCA_POLICE_BPF_H
#define MLCCA_POLICE_BPF_H

/* The time in ns that a frame costs; 0: it is not policed. per_byte is in 2^-8 ns. */
static __always_inline __u64 cost_of(__u64 per_frame, __u64 per_byte, __u32 len)
{
	return per_frame + ((len ? len : 1) * per_byte >> 8);
}

/*
 * Whether a frame conforms; if so, its cost is added to *next. The exchange fails if another CPU
 * has added a cost in between; it could fail for that reason alone only if TURN_TRIES frames came
 * between two steps of this program.
 */
#define TURN_TRIES 64

static __always_inline bool take_turn(__u64 *next, __u64 cost, __u64 tolerance, __u64 now)
{
	__u64 due, turn;
	__u32 i;

	for (i = 0; i < TURN_TRIES; i++) {
		due = READ_ONCE(*next);
		turn = due > now ? due : now;
		if (turn - now > tolerance)
			return false;
		if (__sync_val_compare_and_swap(next, due, turn + cost) == due)
			return true;
	}
	return false;
}

#endif
