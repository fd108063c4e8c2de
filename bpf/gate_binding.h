/* SPDX-License-Identifier: GPL-2.0-only OR BSD-2-Clause */
/* The part of gate.h for FAMOUSO's tags; it belongs to the same layout version. */
#ifndef MLCCA_GATE_BINDING_H
#define MLCCA_GATE_BINDING_H

#include <linux/types.h>

/* FAMOUSO: the broker's replies, and the subject by which nodes announce their subscriptions. */
#define GATE_REPLY_TAG 4
#define GATE_REPLY_ID  0x1f5fc004U
#define GATE_SUBSCRIBE 0x5355425343524942ULL /* "SUBSCRIB" */
#define GATE_BINDINGS  4096		     /* for one interface; a power of two */
#define GATE_ASKERS    256		     /* nodes, by their number in replies */

/*
 * FAMOUSO: a subject and the tag of its frames on this bus, as user space states it. It is compared
 * with the broker's replies. A reply that assigns the tag to another subject, or another tag to the
 * subject, is a contradiction: the slots of the binding refuse before the next frame. User space
 * ends the contradiction (`settled`); it may do so once a complete reply has assigned the tag to
 * the subject again (`confirmed`), and while the verdicts of these slots deny.
 */
struct gate_binding {
	__u64 subject; /* 0: not in use */
	__u64 other;   /* the subject that the tag was assigned to, as far as it is known */
	__u32 contradictions;
	__u32 settled;	 /* written by user space: so many of them are over */
	__u32 confirmed; /* number of contradictions when a reply confirmed the tag */
	__u16 etag;	 /* 0: not known yet */
	__u16 dealt;	 /* tag that the latest complete reply assigned to the subject; 0: none */
	__u8 halves;	 /* bits: known halves of `other`; 0: the subject got another tag */
	__u8 pad[7];
};

/* The first half of a reply, until the second one arrives. */
struct gate_half {
	__u32 part; /* the first half of the subject */
	__u16 etag;
	__u8 there;
	__u8 broker; /* it has the form that a broker sends */
};

#endif
