/* SPDX-License-Identifier: GPL-2.0-only OR BSD-2-Clause */
/* Finds the event in a packet, for tc and XDP. */
#ifndef MLCCA_ETHER_PARSE_BPF_H
#define MLCCA_ETHER_PARSE_BPF_H

struct packet {
	void *ctx;
	const void *data;
	const void *end; /* end of what can be read in place */
	__u32 len;	 /* length of the packet */
	bool xdp;
};

enum nature {
	NOT_EVENT,	 /* no event, and nothing that may carry one */
	NOT_EVENT_FIRST, /* first IP fragment of a datagram that is no event */
	EVENT,		 /* a complete event, or the first IP fragment of one */
	LATER,		 /* later IP fragment, without the subject */
	MALFORMED,
	OPAQUE,
};

struct event {
	__u64 subject;	  /* if it is malformed: 0 unless it could be read */
	__u64 station;	  /* sender, see ether_station() */
	__u32 len;	  /* payload bytes */
	__u32 form;	  /* ETHER_UNFRAGMENTED or ETHER_FRAGMENT */
	__u32 mark;	  /* its mark when the gate read it */
	__u32 source;	  /* egress: where it comes from, as source_of() in gate_frame.bpf.h */
	__u32 uid;	  /* user of the local program that sends it */
	__u32 generation; /* generation of verdicts used for the decision */
	__u32 read;	  /* sum of what was read for the decision, see moved_on() */
	/* For IP packets: */
	__u32 offset;  /* of the fragment in the datagram */
	__u32 payload; /* bytes of the datagram in this packet */
	__u32 whole;   /* bytes of the datagram according to its UDP header */
	bool more;     /* more fragments follow */
	bool known;    /* a slot is for its station alone */
	/* For the innermost Ethernet frame, see take_mac(): */
	__u8 mac[ETH_ALEN];
	struct ether_fragment_key key;
};

/*
 * Reads one number or header at offset `at`; false beyond the end. `at` must be bounded, so that
 * the verifier can check it.
 */
#define TAKE(p, at, to)                                                                            \
	({                                                                                         \
		const typeof(*(to)) *from_ = (p)->data + (at);                                     \
		bool ok_;                                                                          \
		if (!direct_access) {                                                              \
			ok_ =                                                                      \
			    !((p)->xdp ? bpf_xdp_load_bytes((p)->ctx, (at), (to), sizeof(*(to)))   \
				       : bpf_skb_load_bytes((p)->ctx, (at), (to), sizeof(*(to)))); \
		} else {                                                                           \
			ok_ = (const void *)(from_ + 1) <= (p)->end;                               \
			if (ok_)                                                                   \
				*(to) = *from_;                                                    \
		}                                                                                  \
		ok_;                                                                               \
	})

/* Skips the addresses and tags of a frame at *at: *at is where the payload begins afterwards. */
static __always_inline enum nature parse_link(const struct packet *p, __u32 *at, __be16 *protocol)
{
	__u32 i;

	*at += ETH_HLEN;
	if (!TAKE(p, *at - 2, protocol))
		return MALFORMED;
#pragma unroll
	for (i = 0; i < ETHER_TAGS; i++) {
		if (*protocol != bpf_htons(ETH_P_8021Q) && *protocol != bpf_htons(ETH_P_8021AD))
			return NOT_EVENT;
		*at += 4;
		if (!TAKE(p, *at - 2, protocol))
			return MALFORMED;
	}
	/* The frame has more tags than are skipped. */
	return *protocol == bpf_htons(ETH_P_8021Q) || *protocol == bpf_htons(ETH_P_8021AD)
		   ? OPAQUE
		   : NOT_EVENT;
}

static __always_inline bool is_event_port(__be16 port)
{
	return port == bpf_htons(ETHER_MULTICAST_PORT) || port == bpf_htons(ETHER_BROADCAST_PORT);
}

static __always_inline enum nature parse_udp(const struct packet *p, __u32 at, struct event *e)
{
	struct udphdr udp;
	__be64 subject;
	__u8 flag;

	if (e->payload < sizeof(udp) || !TAKE(p, at, &udp))
		return MALFORMED;
	if (!is_event_port(udp.dest))
		return e->more ? NOT_EVENT_FIRST : NOT_EVENT;
	e->whole = bpf_ntohs(udp.len);
	at += ETHER_UDP_HEADER;
	if (e->payload < ETHER_UDP_HEADER + sizeof(subject) || !TAKE(p, at, &subject))
		return MALFORMED;
	e->subject = bpf_be64_to_cpu(subject);
	if (e->more ? e->whole <= e->payload : e->whole != e->payload)
		return MALFORMED;
	if (e->payload < ETHER_UDP_HEADER + ETHER_EVENT_HEADER ||
	    !TAKE(p, at + sizeof(subject), &flag) || flag > 1)
		return MALFORMED;
	e->len = e->whole - ETHER_UDP_HEADER - ETHER_EVENT_HEADER;
	e->form = flag ? ETHER_FRAGMENT : ETHER_UNFRAGMENTED;
	return EVENT;
}

static __always_inline enum nature parse_ip(const struct packet *p, __u32 at, struct event *e)
{
	struct iphdr ip;
	__u32 header, total, fragment;

	if (!TAKE(p, at, &ip))
		return MALFORMED;
	if (ip.protocol != IPPROTO_UDP)
		return NOT_EVENT;
	e->station = bpf_ntohl(ip.saddr);
	header = ip.ihl * 4;
	total = bpf_ntohs(ip.tot_len);
	if (ip.version != 4 || header < sizeof(ip) || total <= header || total > p->len - at)
		return MALFORMED;
	e->payload = total - header;
	fragment = bpf_ntohs(ip.frag_off);
	e->offset = (fragment & 0x1fff) * 8;
	e->more = fragment & 0x2000;
	/*
	 * All fragments except the last have a multiple of 8 bytes, and none ends beyond the
	 * largest length.
	 */
	if ((e->more && e->payload % 8) || e->offset + e->payload > 0xffff)
		return MALFORMED;
	if (e->more || e->offset) {
		e->key.source = ip.saddr;
		e->key.destination = ip.daddr;
		e->key.id = ip.id;
	}
	return e->offset ? LATER : parse_udp(p, at + header, e);
}

/* A packet of AWDSNL without its address: kind, pad, size, subject, event. */
static __always_inline enum nature parse_publish(const struct packet *p, __u32 at, __u8 kind,
						 struct event *e)
{
	__be64 subject;
	__be16 size;

	if (!TAKE(p, at + 2, &size) || !TAKE(p, at + ETHER_AWDS_PUBLISH_HEADER, &subject))
		return MALFORMED;
	e->subject = bpf_be64_to_cpu(subject);
	e->len = bpf_ntohs(size);
	if (e->len < sizeof(subject) || e->len > p->len - at - ETHER_AWDS_PUBLISH_HEADER)
		return MALFORMED;
	e->len -= sizeof(subject);
	e->form = kind == ETHER_AWDS_PUBLISH ? ETHER_UNFRAGMENTED : ETHER_FRAGMENT;
	return EVENT;
}

/* Kinds of packets by which an AWDS mesh organises itself; they are not affected. */
static __always_inline bool is_awds_business(__u8 kind)
{
	switch (kind) {
	case ETHER_AWDS_TOPOLOGY:
	case ETHER_AWDS_PING:
	case ETHER_AWDS_CS_DETECT:
	case ETHER_AWDS_CS_ANSWER:
	case ETHER_AWDS_TRAFFIC:
	case ETHER_AWDS_METRIC:
	case ETHER_AWDS_LOCK:
	case ETHER_AWDS_SUBSCRIBE:
	case ETHER_AWDS_NODE_ATTRIBUTES:
	case ETHER_AWDS_FLOW_MANAGEMENT:
		return true;
	}
	return false;
}

/*
 * Parses an AWDS packet. *inner: where the Ethernet frame in it begins; unchanged if there is none.
 */
static __always_inline enum nature parse_awds(const struct packet *p, __u32 at, struct event *e,
					      __u32 *inner)
{
	__u32 from = at + ETHER_AWDS_SOURCE;
	__u8 type, kind;
	__be16 high;
	__be32 low;

	if (!TAKE(p, at, &type))
		return MALFORMED;
	type &= 3;
	if (type == ETHER_AWDS_FLOW)
		return OPAQUE;
	if (type != ETHER_AWDS_FLOOD && type != ETHER_AWDS_UNICAST)
		return NOT_EVENT;
	at += type == ETHER_AWDS_FLOOD ? ETHER_AWDS_FLOOD_KIND : ETHER_AWDS_UNICAST_KIND;
	if (!TAKE(p, at, &kind))
		return MALFORMED;
	if (kind == ETHER_AWDS_FRAME) {
		*inner = at + 1;
		return NOT_EVENT;
	}
	if (kind == ETHER_AWDS_PUBLISH || kind == ETHER_AWDS_PUBLISH_FRAGMENT) {
		if (!TAKE(p, from, &high) || !TAKE(p, from + sizeof(high), &low))
			return MALFORMED;
		e->station = ETHER_MAC | (__u64)bpf_ntohs(high) << 32 | bpf_ntohl(low);
		return parse_publish(p, at, kind, e);
	}
	return is_awds_business(kind) ? NOT_EVENT : OPAQUE;
}

/* Parses a packet of batman-adv, see <linux/batadv_packet.h>. *inner: as for parse_awds(). */
static __always_inline enum nature parse_batman(const struct packet *p, __u32 at, __u32 *inner)
{
	struct {
		__u8 type;
		__u8 version;
	} head;

	if (!TAKE(p, at, &head))
		return MALFORMED;
	if (head.version != BATADV_COMPAT_VERSION)
		return OPAQUE;
	switch (head.type) {
	case BATADV_BCAST:
		*inner = at + sizeof(struct batadv_bcast_packet);
		return NOT_EVENT;
	case BATADV_UNICAST:
		*inner = at + sizeof(struct batadv_unicast_packet);
		return NOT_EVENT;
	case BATADV_UNICAST_4ADDR:
		*inner = at + sizeof(struct batadv_unicast_4addr_packet);
		return NOT_EVENT;
	/* Packets by which the mesh organises itself are not affected. */
	case BATADV_IV_OGM:
	case BATADV_ELP:
	case BATADV_OGM2:
	case BATADV_ICMP:
	case BATADV_UNICAST_TVLV:
		return NOT_EVENT;
	}
	/* Fragments, coded packets and later kinds of packets may contain an event. */
	return OPAQUE;
}

#include "bpf/ether_wpan.bpf.h"

static __always_inline bool is_mesh(__be16 protocol)
{
	return protocol == bpf_htons(ETHER_P_AWDS) || protocol == bpf_htons(ETH_P_BATMAN);
}

/* Stores the sender of the frame whose addresses are at `at`. */
static __always_inline void take_mac_at(const struct packet *p, __u32 at, struct event *e)
{
	struct {
		__u8 octets[ETH_ALEN];
	} from;

	if (TAKE(p, at + ETH_ALEN, &from))
		__builtin_memcpy(e->mac, &from, sizeof(from));
}

/*
 * Stores the frame's sender for reports. AWDS packets and frames of 802.15.4 state a station
 * instead.
 */
static __always_inline void take_mac(const struct packet *p, struct event *e)
{
	if (!is_wpan && !e->key.inside && !(e->station & ETHER_MAC))
		take_mac_at(p, 0, e);
}

static __always_inline enum nature parse(const struct packet *p, struct event *e)
{
	__u32 at = 0, inner = 0;
	enum nature nature;
	__be16 protocol;

	if (is_wpan)
		return parse_wpan(p, e);
	nature = parse_link(p, &at, &protocol);
	if (nature != NOT_EVENT)
		return nature;
	if (is_mesh(protocol)) {
		nature = protocol == bpf_htons(ETH_P_BATMAN) ? parse_batman(p, at, &inner)
							     : parse_awds(p, at, e, &inner);
		if (!inner)
			return nature;
		at = inner;
		take_mac_at(p, at, e);
		nature = parse_link(p, &at, &protocol);
		if (nature != NOT_EVENT)
			return nature;
		if (is_mesh(protocol))
			return OPAQUE;
		e->key.inside = 1;
	}
	return protocol == bpf_htons(ETH_P_IP) ? parse_ip(p, at, e) : NOT_EVENT;
}

/*
 * Whether the buffer is the local copy of a multicast or broadcast that a program on this host
 * sends. The kernel makes it before the gate sees the packet leave; it begins with the IP header.
 * Its sender is unknown, and an event in it was not admitted for anyone.
 */
static __always_inline bool is_event_copy(const struct packet *p, __be16 protocol, struct event *e)
{
	enum nature nature;

	if (protocol != bpf_htons(ETH_P_IP))
		return false;
	nature = parse_ip(p, 0, e);
	return nature != NOT_EVENT && nature != NOT_EVENT_FIRST;
}

#endif
