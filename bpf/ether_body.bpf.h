/* SPDX-License-Identifier: GPL-2.0-only OR BSD-2-Clause */
/*
 * The gate of one Ethernet-like interface: passes the events that a slot admits, and drops all
 * other events. Other traffic is not affected. skb.bpf.h or test_skb.bpf.h, which describe a socket
 * buffer, must be included before.
 */
#ifndef MLCCA_ETHER_BODY_BPF_H
#define MLCCA_ETHER_BODY_BPF_H

#include "bpf/ether.h"
#include "bpf/once.bpf.h"
#include "bpf/shared.bpf.h"
#include "bpf/refuse.bpf.h"
#include "bpf/police.bpf.h"
#include "bpf/sample.bpf.h"

/* These constants are set before loading. */
const volatile __u32 ifindex = 0;
const volatile __u32 bucket_mask = 0;
const volatile __u32 slots_of_bank = 0;
const volatile __u32 banks = 1;
/* The prefilter is read before the buckets. */
const volatile __u8 has_prefilter = false;
/* Reads packets by packet pointers; false if the verifier refuses unaligned loads. */
const volatile __u8 direct_access = true;
/* The interface is IEEE 802.15.4. The protocol in a buffer is what its sender states there. */
const volatile __u8 is_wpan = false;
#include "bpf/ether_maps.bpf.h"

MAPPED_ARRAY(buckets, __u64);
MAPPED_ARRAY(ether_prefilter, struct ether_prefilter_part);
MAPPED_ARRAY(contracts, struct ether_contract);
MAPPED_ARRAY(counts, struct gate_count); /* index: [bank][slot] */
MAPPED_ARRAY(audits, struct gate_audit); /* index: slot */
MAPPED_ARRAY(cpus, struct ether_cpu);

#include "bpf/ether_parse.bpf.h"
#include "bpf/ether_count.bpf.h"
#include "bpf/ether_decide.bpf.h"
#include "bpf/gate_watch.bpf.h"
#include "bpf/ether_admit.bpf.h"
#include "bpf/ether_fragment.bpf.h"

/* Longest part of a packet that is read: an event in AWDS with tags and options. */
#define HEADERS 160

static __always_inline struct packet packet_of(struct __sk_buff *skb)
{
	return (struct packet){.ctx = skb,
			       .data = (void *)(long)skb->data,
			       .end = (void *)(long)skb->data_end,
			       .len = skb->len};
}

/*
 * Parses a packet. Its headers may be in pages that cannot be read in place; they are made linear
 * then, but for UDP and AWDS only, since nothing after the IP header is read of other packets. It
 * is not static, so that the verifier checks it once and takes any number for its result.
 */
__noinline __u32 read_event(struct __sk_buff *skb, struct event *e)
{
	enum nature nature;
	struct packet p;

	if (!e)
		return MALFORMED;
	p = packet_of(skb);
	nature = parse(&p, e);
	if (nature != MALFORMED || p.data + p.len == p.end || !direct_access)
		return nature;
	if (bpf_skb_pull_data(skb, p.len < HEADERS ? p.len : HEADERS))
		return MALFORMED;
	p = packet_of(skb);
	__builtin_memset(&e->key, 0, sizeof(e->key));
	return parse(&p, e);
}

/* Determines the local or remote sender, for egress. */
static __always_inline void take_sender(struct __sk_buff *skb, struct event *e)
{
	__u32 from = skb->ingress_ifindex;

	e->uid = is_local(skb) ? bpf_get_socket_uid(skb) : GATE_ANY_UID;
	e->source = is_local(skb) ? 0 : from ? from : GATE_NO_SOURCE;
}

static __always_inline void note_refusal(struct __sk_buff *skb, struct ether_cpu *cpu,
					 __u32 direction, __u32 slot, __u32 reason, struct event *e)
{
	struct packet p;

	if (names_sender(slot, reason)) {
		p = packet_of(skb);
		take_mac(&p, e);
	}
	if (slot < ETHER_FIRST_SLOT && reason != GATE_R_UNKNOWN)
		e->len = skb->len;
	note_event(cpu, direction, slot, reason, e);
}

/* Checks a first fragment: it is refused if its identification is in use for another datagram. */
static __always_inline __u32 judge_first(const struct event *e, void *others)
{
	return e->more && remembered(others, &e->key) ? GATE_R_FRAGMENT : GATE_R_PASSED;
}

static __always_inline struct decision judge(struct __sk_buff *skb, __u32 direction,
					     struct event *e)
{
	struct decision d = {.slot = direction, .reason = GATE_R_CLOSED};

	if (closed(READ_ONCE(table.epoch)))
		return d;
	/* A buffer with several datagrams, of which only the first would be checked. */
	d.reason = skb->gso_size ? GATE_R_MALFORMED : judge_first(e, &foreign_fragments);
	if (d.reason != GATE_R_PASSED)
		return d;
	return decide(direction, e);
}

static __always_inline int filter_event(struct __sk_buff *skb, struct ether_cpu *cpu,
					__u32 direction, struct event *e)
{
	struct decision d = judge(skb, direction, e);
	bool granted = d.reason == GATE_R_PASSED;

	if (granted && admit(skb, cpu, direction, d.slot, e)) {
		if (e->more)
			remember(&fragments, e, d.slot);
		return TC_ACT_UNSPEC;
	}
	if (e->more && d.reason != GATE_R_FRAGMENT)
		bpf_map_delete_elem(&fragments, &e->key);
	return granted ? drop(cpu, direction, d.slot, GATE_R_EXCESS)
		       : refuse(skb, cpu, direction, d.slot, d.reason, e);
}

/* The mark of the datagram that a later fragment belongs to, as its slot has admitted it. */
static __always_inline __u32 mark_of_later(const struct ether_fragment *f)
{
	__u32 at = f->slot;
	const struct ether_slot *slot = bpf_map_lookup_elem(&slots, &at);
	const struct ether_contract *contract = slot ? contract_of(slot) : NULL;

	return contract ? mark_of(slot, contract, ifindex) : 0;
}

static __always_inline int filter_later(struct __sk_buff *skb, struct ether_cpu *cpu,
					__u32 direction, struct event *e)
{
	struct ether_fragment *f = remembered(&fragments, &e->key);
	struct decision d = judge_later(f, e);

	if (d.reason != GATE_R_PASSED && d.reason != GATE_R_FOREIGN) {
		e->subject = f ? f->subject : 0;
		note_refusal(skb, cpu, direction, d.slot, d.reason, e);
		return drop(cpu, direction, d.slot, d.reason);
	}
	count_reason(cpu, direction, d.reason);
	if (d.reason == GATE_R_FOREIGN)
		return TC_ACT_UNSPEC;
	skb->mark = f && direction == GATE_INGRESS ? mark_of_later(f) : 0;
	return TC_ACT_UNSPEC;
}

static __always_inline int filter(struct __sk_buff *skb, __u32 direction)
{
	struct event e = {.mark = skb->mark, .key.direction = direction};
	struct ether_cpu *cpu = this_cpu();
	enum nature nature;
	__u32 reason;

	if (READ_ONCE(table.retired))
		return TC_ACT_UNSPEC;
	nature = read_event(skb, &e);
	if (!cpu)
		return TC_ACT_SHOT;
	if (nature == NOT_EVENT)
		goto foreign;
	if (nature == NOT_EVENT_FIRST) {
		reason = judge_first(&e, &fragments);
		if (reason != GATE_R_PASSED) {
			if (direction == GATE_EGRESS)
				take_sender(skb, &e);
			note_refusal(skb, cpu, direction, direction, reason, &e);
			return drop(cpu, direction, direction, reason);
		}
		remember(&foreign_fragments, &e, 0);
		goto foreign;
	}
	if (direction == GATE_EGRESS)
		take_sender(skb, &e);
	if (nature == LATER)
		return filter_later(skb, cpu, direction, &e);
	/* No token may leave the machine or the namespace. */
	skb->mark = 0;
	if (nature != EVENT)
		return refuse(skb, cpu, direction, direction,
			      nature == OPAQUE ? GATE_R_OPAQUE : GATE_R_MALFORMED, &e);
	return filter_event(skb, cpu, direction, &e);

foreign:
	count_reason(cpu, direction, GATE_R_FOREIGN);
	return TC_ACT_UNSPEC;
}

/* Not static, for the same reason as read_event(). */
__noinline __u32 copies_event(struct __sk_buff *skb)
{
	struct packet p = packet_of(skb);
	struct event e = {};

	return is_event_copy(&p, skb->protocol, &e);
}

SEC("tc")
int ether_ingress(struct __sk_buff *skb)
{
	struct ether_cpu *cpu;

	if (skb->pkt_type != PACKET_LOOPBACK)
		return filter(skb, GATE_INGRESS);
	cpu = this_cpu();
	if (cpu)
		count_reason(cpu, GATE_INGRESS, GATE_R_ECHO);
	return copies_event(skb) && READ_ONCE(control.mode) != GATE_AUDIT &&
		       !READ_ONCE(table.retired)
		   ? TC_ACT_SHOT
		   : TC_ACT_UNSPEC;
}

SEC("tc")
int ether_egress(struct __sk_buff *skb) { return filter(skb, GATE_EGRESS); }

static __always_inline struct packet early_packet_of(struct xdp_md *ctx)
{
	return (struct packet){.ctx = ctx,
			       .data = (void *)(long)ctx->data,
			       .end = (void *)(long)ctx->data_end,
			       .len = ctx->data_end - ctx->data,
			       .xdp = true};
}

__noinline __u32 read_early(struct xdp_md *ctx, struct event *e)
{
	struct packet p = early_packet_of(ctx);

	return e ? parse(&p, e) : MALFORMED;
}

/*
 * XDP, where the driver has it: drops what ingress would drop, before it costs a buffer and before
 * packet sockets see it. What is not certain is left to ingress, which also polices, counts what
 * passes, and knows fragments.
 */
SEC("xdp")
int ether_early(struct xdp_md *ctx)
{
	struct decision d = {.slot = GATE_INGRESS, .reason = GATE_R_CLOSED};
	struct ether_cpu *cpu;
	struct event e = {};
	enum nature nature;
	struct packet p;

	if (READ_ONCE(control.mode) == GATE_AUDIT || READ_ONCE(table.retired))
		return XDP_PASS;
	nature = read_early(ctx, &e);
	if (nature == NOT_EVENT || nature == NOT_EVENT_FIRST || nature == LATER ||
	    (nature == EVENT && e.more))
		return XDP_PASS;
	if (nature != EVENT)
		d.reason = nature == OPAQUE ? GATE_R_OPAQUE : GATE_R_MALFORMED;
	else if (!closed(READ_ONCE(table.epoch)))
		d = decide(GATE_INGRESS, &e);
	if (d.reason == GATE_R_PASSED)
		return XDP_PASS;
	cpu = this_cpu();
	if (names_sender(d.slot, d.reason)) {
		p = early_packet_of(ctx);
		take_mac(&p, &e);
	}
	if (d.slot < ETHER_FIRST_SLOT && d.reason != GATE_R_UNKNOWN)
		e.len = ctx->data_end - ctx->data;
	if (cpu) {
		note_event(cpu, GATE_INGRESS, d.slot, d.reason, &e);
		set_last_reason(d.slot, d.reason);
		count_drop(cpu, GATE_INGRESS, d.slot, d.reason);
	}
	return XDP_DROP;
}

#endif
