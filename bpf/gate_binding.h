/* SPDX-License-Identifier: GPL-2.0-only OR BSD-2-Clause */
/* The part of gate.h that is about FAMOUSO's tags; of the same layout version. */
#ifndef MLCCA_GATE_BINDING_H
#define MLCCA_GATE_BINDING_H

#include <linux/types.h>

/* FAMOUSO: the broker's replies, and the subject by which nodes announce what they subscribe to. */
#define GATE_REPLY_TAG 4
#define GATE_REPLY_ID  0x1f5fc004U
#define GATE_SUBSCRIBE 0x5355425343524942ULL /* "SUBSCRIB" */
#define GATE_BINDINGS  4096		     /* of one interface; a power of two */
#define GATE_ASKERS    256		     /* nodes, as replies name them */

/*
 * FAMOUSO: a subject and the tag that its frames have on this bus, as user space states it, held
 * against the replies of the broker. A reply that deals the tag to another subject, or the subject
 * another tag, is a contradiction: the slots of the binding refuse before the next frame. It is
 * over when user space says so (`settled`), which it may do once a whole reply has dealt the tag to
 * the subject again (`confirmed`), and while the verdicts of these slots deny.
 */
struct gate_binding {
	__u64 subject; /* 0: not in use */
	__u64 other;   /* the subject that the tag was dealt to, as far as it is known */
	__u32 contradictions;
	__u32 settled;	 /* by user space: so many of them are over */
	__u32 confirmed; /* so many there were when the tag was dealt as stated again */
	__u16 etag;	 /* 0: not known yet */
	__u16 dealt;	 /* tag that a whole reply dealt to the subject last; 0: none */
	__u8 halves; /* bits: which halves of `other` are known; 0: the subject got another tag */
	__u8 pad[7];
};

/* First half of a reply, until the second one comes. */
struct gate_half {
	__u32 part; /* the first half of the subject */
	__u16 etag;
	__u8 there;
	__u8 broker; /* it is as a broker sends it */
};

#endif
