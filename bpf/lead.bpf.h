/* SPDX-License-Identifier: GPL-2.0-only OR BSD-2-Clause */
/*
 * The position of a CAN frame in its buffer. Frames that a controller's driver receives have struct
 * can_skb_priv in front, which the driver takes for a link-layer header: ingress sees it, egress
 * and virtual devices do not. It has 16 bytes since Linux 5.11.
 */
#ifndef MLCCA_LEAD_BPF_H
#define MLCCA_LEAD_BPF_H

#define MAX_LEAD  32
#define LEAD_STEP 8
#define XL_LEAD	  16 /* no kernel before 5.11 has CAN XL */

#define XL_PROTOCOL 0x000e /* ETH_P_CANXL, which older kernel headers lack */

static __always_inline bool is_lead(__u32 lead)
{
	return lead <= MAX_LEAD && lead % LEAD_STEP == 0;
}

#endif
