/* SPDX-License-Identifier: GPL-2.0-only OR BSD-2-Clause */
/*
 * What the gate programs of Ethernet-like links and user space share, beside gate.h. Events carry
 * their 64-bit subject. A change of any layout here needs a new ETHER_LAYOUT_VERSION.
 */
#ifndef MLCCA_ETHER_H
#define MLCCA_ETHER_H

#include <linux/types.h>

#include "bpf/gate.h"

#define ETHER_LAYOUT_VERSION 3

/* Datagrams to these ports are events, whatever address they go to: a receiver takes them all. */
#define ETHER_MULTICAST_PORT 9999
#define ETHER_BROADCAST_PORT 8888

/* In a datagram: subject, and whether what follows is a fragment of an event. */
#define ETHER_UDP_HEADER   8
#define ETHER_EVENT_HEADER 9
#define ETHER_MAX_PAYLOAD  8183

/* IEEE 802.1Q and 802.1ad tags that are skipped, beside one that the device has taken off.
 */
#define ETHER_TAGS 2

/* AWDS, behind its ethertype. Numbers are those of its packets; publish* are those of AWDSNL. */
#define ETHER_P_AWDS		    0x8334
#define ETHER_AWDS_FLOOD	    1
#define ETHER_AWDS_UNICAST	    2
#define ETHER_AWDS_FLOW		    3
#define ETHER_AWDS_SOURCE	    1  /* where the MAC address of the sender stands */
#define ETHER_AWDS_FLOOD_KIND	    16 /* where the kind of packet stands */
#define ETHER_AWDS_UNICAST_KIND	    22
#define ETHER_AWDS_TOPOLOGY	    0
#define ETHER_AWDS_PING		    42
#define ETHER_AWDS_CS_DETECT	    43
#define ETHER_AWDS_CS_ANSWER	    44
#define ETHER_AWDS_TRAFFIC	    96
#define ETHER_AWDS_METRIC	    97
#define ETHER_AWDS_FRAME	    98 /* an Ethernet frame */
#define ETHER_AWDS_LOCK		    100
#define ETHER_AWDS_PUBLISH_FRAGMENT 0x7b
#define ETHER_AWDS_PUBLISH	    0x7c
#define ETHER_AWDS_SUBSCRIBE	    0x7d
#define ETHER_AWDS_NODE_ATTRIBUTES  0x81
#define ETHER_AWDS_FLOW_MANAGEMENT  0x82
#define ETHER_AWDS_PUBLISH_HEADER   4 /* kind, pad, size of what follows */

/* Forms of an event, a bit set; GATE_EXCESS_PASSES is in the same bits. */
#define ETHER_UNFRAGMENTED 1
#define ETHER_FRAGMENT	   2

/* Slots: 0 and 1 count what has no slot, per direction. */
#define ETHER_FIRST_SLOT 2
#define ETHER_MIN_SLOTS	 4096
#define ETHER_MAX_SLOTS	 (1U << 22)
#define ETHER_CONTRACTS	 65536 /* at most; 0 is not used */
/* Tables with more slots have one bank of counters for all CPUs: memory, see ether_table. */
#define ETHER_BANKED_SLOTS 16384

/*
 * Tables with more slots have a prefilter in front, small enough for a second-level cache: one
 * octet a bucket, so many of them in a value of its map.
 */
#define ETHER_PREFILTERED_SLOTS 16384
#define ETHER_PREFILTER_BUCKETS 64

/* Slots whose events can be watched; 0 is not used. What more is granted is not watched. */
#define ETHER_WATCHES 4096

/*
 * IP fragments: datagrams under way at once of which the first one is remembered, for events and
 * for others, and how long, as a receiver may reassemble.
 */
#define ETHER_FRAGMENTS	  2048
#define ETHER_FRAGMENT_NS 30000000000ULL

/*
 * What was admitted, shared by all slots with the same of it. User space changes none that a slot
 * refers to: another one takes its place.
 */
struct ether_contract {
	__u32 uid;    /* local sender's user, or GATE_ANY_UID */
	__u32 source; /* egress: ifindex it must have entered by; 0: sent by a local program */
	__u32 station_high; /* of ether_station() */
	__u16 max_len;	    /* payload bytes of a datagram */
	__u16 forms;
	__u64 per_frame; /* as in gate_slot */
	__u64 per_byte;
	__u64 tolerance;
	__u64 pad[3];
};

/*
 * One (subject, publisher) on one interface and direction. Half a cache line. User space never
 * changes a live slot other than `verdict`, `contract`, `watch` and `next`. In the chain of a
 * bucket slots of a station stand before the wildcard.
 */
struct ether_slot {
	__u64 subject; /* host order */
	__u64 due;     /* as in gate_slot */
	__u32 next;    /* further slot of the same bucket; 0: none */
	__u32 station; /* lower half of ether_station() */
	__u16 contract;
	__u8 verdict[2]; /* enum gate_verdict, in even and in odd generations */
	__u8 direction;
	__u8 last_reason; /* as gate_table.last_reason; written by the program */
	__u16 watch;	  /* number of its gate_watch; 0: not supervised */
};

/*
 * A bucket is one word: the first slot in the lower half, and in the upper one a bit for each
 * subject of the chain, by ether_fingerprint(). Most subjects without a slot are decided by these
 * bits alone.
 */
#define ETHER_FINGERPRINT_SHIFT 32

/* Of each bucket the bits of all subjects of its chain, by ether_prefilter_bits(). */
struct ether_prefilter_part {
	__u8 bits[ETHER_PREFILTER_BUCKETS];
};

/* What is the same for the whole interface; the only variable of .bss. */
struct ether_table {
	__u32 layout_version;
	__u32 slots;   /* entries of the slot map */
	__u32 buckets; /* a power of two */
	__u32 banks;   /* of counters: one for each CPU, or one for all */
	__u64 seed;    /* of the hash, random: a sender cannot choose subjects that collide */
	__u64 unknown_frames; /* as in gate_table */
	__u32 contracts;
	__u32 watches_end; /* all watches that were ever used are below this one */
	__u64 sample_due;  /* as in gate_table */
	__u32 retired;	   /* as in gate_table */
	__u32 epoch;	   /* as in gate_table */
	__u32 pad[2];
	__u64 would_drop[GATE_DIRECTIONS][GATE_REASONS]; /* as in gate_table */
};

/* A datagram without a slot; as gate_seen, with the latest sender. */
struct ether_seen {
	__u64 sequence;
	__u64 count;
	__u64 subject;
	__u32 len;
	__u8 direction;
	__u8 pad[3];
	__u64 station; /* whom it is from: as ether_station() */
	__u8 mac[6];   /* of the Ethernet frame that it was in, 0: not read */
	__u8 pad2[2];
};

/* One for each possible CPU. */
struct ether_cpu {
	__u64 reasons[GATE_DIRECTIONS][GATE_REASONS]; /* packets: an IP fragment is one */
	struct ether_seen seen[GATE_SEEN];
};

/* A datagram in IP fragments. */
struct ether_fragment_key {
	__u32 source; /* addresses and id as they stand in the header */
	__u32 destination;
	__u16 id;
	__u8 direction;
	__u8 inside; /* of a packet of a mesh */
};

struct ether_fragment {
	__u64 until; /* CLOCK_MONOTONIC ns */
	__u64 subject;
	__s64 left; /* bytes that may still follow: of all of it together no more than it says */
	__u32 slot;
	__u16 first; /* bytes of the first fragment: nothing may be laid over them */
	__u16 whole; /* bytes of the datagram with its UDP header; 0: no event */
};

/*
 * Entries of a map that remembers so many. The kernel keeps datagrams that are complete longer than
 * new ones, and entries in reserve on each CPU: of four times as many entries 2048 just hold.
 */
static inline __u32 ether_fragment_entries(__u32 cpus) { return 5 * ETHER_FRAGMENTS + 128 * cpus; }

static inline __u64 ether_hash(__u64 seed, __u64 subject, __u32 direction)
{
	__u64 h = (subject ^ seed) + direction;

	h = (h ^ h >> 32) * 0x9e3779b97f4a7c15ULL;
	h = (h ^ h >> 32) * 0xd6e8feb86659fd93ULL;
	return h ^ h >> 32;
}

/*
 * What a slot's frames come from: an IPv4 address, ETHER_MAC and a MAC address, or on 802.15.4
 * ETHER_SHORT, PAN and short address or ETHER_EXTENDED and the extended address. 0: a wildcard
 * for who has no slot of that subject for himself. What is forwarded from one Ethernet-like
 * interface to another has one station in both slots, so that it is the publisher of its
 * gate_origin().
 */
#define ETHER_MAC      (1ULL << 48)
#define ETHER_SHORT    (1ULL << 49)
#define ETHER_EXTENDED (1ULL << 56) /* the bit of a group, which no station has in its address */

static inline __u64 ether_station(const struct ether_slot *slot,
				  const struct ether_contract *contract)
{
	return (__u64)contract->station_high << 32 | slot->station;
}

/* The bit of a subject in the upper half of its bucket. */
static inline __u64 ether_fingerprint(__u64 hash)
{
	return 1ULL << (ETHER_FINGERPRINT_SHIFT + (hash >> 59));
}

/* The bits of a subject in the octet of its bucket: two, seldom one. */
static inline __u8 ether_prefilter_bits(__u64 hash)
{
	return (__u8)(1U << (hash >> 61) | 1U << (hash >> 56 & 7));
}

GATE_ASSERT(sizeof(struct ether_contract) == 64, "ether_contract is pinned layout");
GATE_ASSERT(sizeof(struct ether_slot) == 32, "ether_slot is pinned layout");
GATE_ASSERT(sizeof(struct ether_table) == 64 + 256, "ether_table is pinned layout");
GATE_ASSERT(sizeof(struct ether_seen) == 48, "ether_seen is pinned layout");
GATE_ASSERT(sizeof(struct ether_cpu) == 256 + 48 * 64, "ether_cpu is pinned layout");
GATE_ASSERT(sizeof(struct ether_fragment_key) == 12, "a hash key has no holes");
GATE_ASSERT(sizeof(struct ether_fragment) == 32, "ether_fragment is pinned layout");

#endif
