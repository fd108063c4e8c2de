/* SPDX-License-Identifier: GPL-2.0-only OR BSD-2-Clause */
/* What the sender of a dropped frame gets from its system call. */
#ifndef MLCCA_REFUSE_BPF_H
#define MLCCA_REFUSE_BPF_H

/*
 * Set before loading. True: the program that sent a frame dropped at egress gets success; otherwise
 * ENOBUFS.
 */
const volatile __u8 silent = false;

/*
 * The action of a drop. TC_ACT_STOLEN would report success to the sender in clsact, but in TCX it
 * makes the kernel run the next program. A redirection is final in both and reports success: the
 * kernel finds no interface with index 0 and frees the frame.
 */
static __always_inline int refusal(__u32 direction)
{
	return silent && direction == GATE_EGRESS ? bpf_redirect(0, 0) : TC_ACT_SHOT;
}

#endif
