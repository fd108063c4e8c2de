/* SPDX-License-Identifier: GPL-2.0-only OR BSD-2-Clause */
/*
 * What a CAN gate keeps about frames that it refuses, beside the counters. A part of gate.h, which
 * asserts the sizes.
 */
#ifndef MLCCA_GATE_SEEN_H
#define MLCCA_GATE_SEEN_H

#include <linux/types.h>

#define GATE_SEEN 64 /* latest frames without a slot, for each CPU; a power of two */

/*
 * Latest senders that slots refused, for each CPU: so many sets of so many, powers of two. In a
 * full set a new sender replaces the one that has been quiet for longest.
 */
#define GATE_SENDER_SETS 8
#define GATE_SENDER_WAYS 8
#define GATE_SENDERS	 (GATE_SENDER_SETS * GATE_SENDER_WAYS)

/* A frame without a slot; entry [hash(id)] is overwritten by the latest one. */
struct gate_seen {
	__u64 sequence; /* unknown_frames when it was last seen; 0: empty or being written */
	__u64 count;	/* frames with this id since it has the entry */
	__u32 can_id;
	__u16 len;
	__u8 format; /* GATE_CLASSIC, GATE_FD or GATE_XL */
	__u8 direction;
};

/*
 * A sender whose frames a slot refused because they are not the granted sender's: the reason is
 * GATE_R_IDENTIFIER or GATE_R_SOURCE. Or, in slot 0 or 1, one whose frames were refused for a
 * reason that concerns no slot, but GATE_R_UNKNOWN and GATE_R_CLOSED.
 */
struct gate_sender {
	__u64 sequence; /* refused_senders when it was last seen; 0: empty or being written */
	__u64 count;	/* its frames since it has the entry */
	__u32 can_id;
	__u32 source; /* egress: as in gate_slot */
	__u32 uid;    /* egress: user of a local sender; otherwise GATE_ANY_UID */
	__u16 slot;
	__u16 len;   /* as in gate_seen; GATE_R_MALFORMED: bytes of the buffer */
	__u8 format; /* GATE_CLASSIC, GATE_FD or GATE_XL; 0: can_id could not be read */
	__u8 direction;
	__u8 reason;
	__u8 pad[5];
};

/* The set of a sender: `who` and `how` are what distinguishes it. */
static inline __u32 gate_sender_set(__u64 who, __u64 how)
{
	return (__u32)((who * 0x9e3779b97f4a7c15ULL + how * 0xd6e8feb86659fd93ULL) >> 40) &
	       (GATE_SENDER_SETS - 1);
}

#endif
