/* SPDX-License-Identifier: GPL-2.0-only OR BSD-2-Clause */
/*
 * How a CAN frame stands in its buffer. What a controller's driver receives has struct can_skb_priv
 * in front of the frame, and takes it for a link-layer header: ingress sees it, egress and virtual
 * devices do not. 16 bytes since Linux 5.11.
 */
#ifndef MLCCA_LEAD_BPF_H
#define MLCCA_LEAD_BPF_H

#define MAX_LEAD  32
#define LEAD_STEP 8
#define XL_LEAD	  16 /* no kernel before 5.11 has CAN XL */

#define XL_PROTOCOL 0x000e /* ETH_P_CANXL, which the headers of older kernels lack */

static __always_inline bool is_lead(__u32 lead)
{
	return lead <= MAX_LEAD && lead % LEAD_STEP == 0;
}

#endif
