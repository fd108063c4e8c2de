// SPDX-License-Identifier: GPL-2.0-only OR BSD-2-Clause
/*
 * The program of an Ethernet-like interface before a daemon runs: like a closed gate, it drops what
 * carries events and does not affect other traffic. It has no tables and counters, so that it is
 * loaded in a tenth of the time.
 */
#include <stdbool.h>
#include <stddef.h>
#include <linux/batadv_packet.h>
#include <linux/bpf.h>
#include <linux/if_ether.h>
#include <linux/if_packet.h>
#include <linux/in.h>
#include <linux/ip.h>
#include <linux/pkt_cls.h>
#include <linux/udp.h>
#include <bpf/bpf_endian.h>
#include <bpf/bpf_helpers.h>

#include "bpf/ether.h"
#include "bpf/once.bpf.h"

struct gate_control control SEC(".data.control"); /* shared by all interfaces */

/* Packets are read by a helper, which works on every machine and is verified quickly. */
#define direct_access false

/* Set before loading: the interface is IEEE 802.15.4. */
const volatile __u8 is_wpan = false;

#include "bpf/ether_parse.bpf.h"
#include "bpf/ether_remember.bpf.h"

/* Not static, so that the verifier checks it once. */
__noinline __u32 read_event(struct __sk_buff *skb, struct event *e)
{
	struct packet p = {.ctx = skb, .len = skb->len};

	return e ? parse(&p, e) : MALFORMED;
}

static __always_inline bool passes(struct __sk_buff *skb, __u32 direction)
{
	struct event e = {.key.direction = direction};
	struct ether_fragment *f;

	switch (read_event(skb, &e)) {
	case NOT_EVENT:
		return true;
	case NOT_EVENT_FIRST:
		remember(&foreign_fragments, &e, 0);
		return true;
	case LATER:
		f = remembered(&foreign_fragments, &e.key);
		return f && !is_overlaid(f, &e);
	}
	return false;
}

static __always_inline int filter(struct __sk_buff *skb, __u32 direction)
{
	if (passes(skb, direction))
		return TC_ACT_UNSPEC;
	skb->mark = 0; /* whoever set it: nothing was granted here */
	return READ_ONCE(control.mode) == GATE_AUDIT ? TC_ACT_UNSPEC : TC_ACT_SHOT;
}

__noinline __u32 copies_event(struct __sk_buff *skb)
{
	struct packet p = {.ctx = skb, .len = skb->len};
	struct event e = {};

	return is_event_copy(&p, skb->protocol, &e);
}

SEC("tc")
int closed_ingress(struct __sk_buff *skb)
{
	if (skb->pkt_type != PACKET_LOOPBACK)
		return filter(skb, GATE_INGRESS);
	return copies_event(skb) && READ_ONCE(control.mode) != GATE_AUDIT ? TC_ACT_SHOT
									  : TC_ACT_UNSPEC;
}

SEC("tc")
int closed_egress(struct __sk_buff *skb) { return filter(skb, GATE_EGRESS); }

char LICENSE[] SEC("license") = "Dual BSD/GPL";
