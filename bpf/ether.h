/* SPDX-License-Identifier: GPL-2.0-only OR BSD-2-Clause */
/*
 * The definitions that the gate programs of Ethernet-like links share with user space, in addition
 * to gate.h. Events carry their 64-bit subject. A change of any layout here needs a new
 * ETHER_LAYOUT_VERSION.
 */
#ifndef MLCCA_ETHER_H
#define MLCCA_ETHER_H

#include <linux/types.h>

#include "bpf/gate.h"

#define ETHER_LAYOUT_VERSION 4

/*
 * Datagrams to these ports are events, whatever their address, because a receiver takes them all.
 */
#define ETHER_MULTICAST_PORT 9999
#define ETHER_BROADCAST_PORT 8888

/* A datagram: UDP header, subject (8 bytes), and a flag whether a fragment of an event follows. */
#define ETHER_UDP_HEADER   8
#define ETHER_EVENT_HEADER 9
#define ETHER_MAX_PAYLOAD  8183

/* IEEE 802.1Q and 802.1ad tags that are skipped, besides one that the device has removed. */
#define ETHER_TAGS 2

/* AWDS, after its ethertype: types and kinds of its packets; PUBLISH* are those of AWDSNL. */
#define ETHER_P_AWDS		    0x8334
#define ETHER_AWDS_FLOOD	    1
#define ETHER_AWDS_UNICAST	    2
#define ETHER_AWDS_FLOW		    3
#define ETHER_AWDS_SOURCE	    1  /* offset of the sender's MAC address */
#define ETHER_AWDS_FLOOD_KIND	    16 /* offset of the kind of packet */
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

/* Bit set of the forms of an event; GATE_EXCESS_PASSES is in the same bits. */
#define ETHER_UNFRAGMENTED 1
#define ETHER_FRAGMENT	   2

/* Slots 0 and 1 count frames without a slot, one for each direction. */
#define ETHER_FIRST_SLOT 2
#define ETHER_CHAIN	 8 /* publishers of one subject, see GATE_CHAIN */
#define ETHER_MIN_SLOTS	 4096
#define ETHER_MAX_SLOTS	 (1U << 22)
#define ETHER_CONTRACTS	 65536 /* at most; 0 is not used */
/* Larger tables have one bank of counters for all CPUs, to save memory; see ether_table. */
#define ETHER_BANKED_SLOTS 16384

/*
 * Larger tables have a prefilter (a Bloom filter) in front of the hash, small enough for a
 * second-level cache: one octet for each bucket, and this number of octets in a value of its map.
 */
#define ETHER_PREFILTERED_SLOTS 16384
#define ETHER_PREFILTER_BUCKETS 64

/* Slots whose events can be watched; 0 is not used. Further slots are granted without a watch. */
#define ETHER_WATCHES 4096

/*
 * IP fragments: the number of datagrams whose first fragment is remembered, separately for events
 * and others, and for how long, since a receiver may take that long to reassemble them.
 */
#define ETHER_FRAGMENTS	  2048
#define ETHER_FRAGMENT_NS 30000000000ULL

/*
 * What was admitted, shared by all slots with the same contract. User space does not change a
 * contract that a slot refers to; it replaces it by another one.
 */
struct ether_contract {
	__u32 uid;	    /* user of the local sender, or GATE_ANY_UID */
	__u32 source;	    /* egress: ifindex that it entered by; 0: sent by a local program */
	__u32 station_high; /* upper half of ether_station() */
	__u16 max_len;	    /* payload bytes of a datagram */
	__u16 forms;
	__u64 per_frame; /* as in gate_slot */
	__u64 per_byte;
	__u64 tolerance;
	__u64 pad[3];
};

/*
 * One (subject, publisher) on one interface and direction; half a cache line. User space changes
 * only `verdict`, `contract`, `watch` and `next` of a live slot. In the chain of a bucket, the
 * slots for a station precede the wildcard entry.
 */
struct ether_slot {
	__u64 subject; /* in host byte order */
	__u64 due;     /* as in gate_slot */
	__u32 next;    /* next slot of the same bucket; 0: none */
	__u32 station; /* lower half of ether_station() */
	__u16 contract;
	__u8 verdict[2]; /* enum gate_verdict, for even and odd generations */
	__u8 direction;
	__u8 last_reason; /* like gate_table.last_reason; written by the program */
	__u16 watch;	  /* number of its gate_watch; 0: not supervised */
};

/*
 * A bucket is one word: the lower half has its first slot, and the upper half one bit for each
 * subject of the chain, see ether_fingerprint(). For most subjects without a slot these bits
 * suffice.
 */
#define ETHER_FINGERPRINT_SHIFT 32

/* For each bucket the bits of all subjects of its chain, see ether_prefilter_bits(). */
struct ether_prefilter_part {
	__u8 bits[ETHER_PREFILTER_BUCKETS];
};

/* The state of the interface; the only variable of .bss. */
struct ether_table {
	__u32 layout_version;
	__u32 slots;   /* number of entries of the slot map */
	__u32 buckets; /* a power of two */
	__u32 banks;   /* banks of counters: one for each CPU, or one for all */
	__u64 seed;    /* of the hash; random, so that no sender can choose colliding subjects */
	__u64 unknown_frames; /* as in gate_table */
	__u32 contracts;
	__u32 watches_end;     /* exclusive upper bound of all watches that were ever used */
	__u64 sample_due;      /* as in gate_table */
	__u32 retired;	       /* as in gate_table */
	__u32 epoch;	       /* as in gate_table */
	__u64 refused_senders; /* as in gate_table */
	__u64 would_drop[GATE_DIRECTIONS][GATE_REASONS]; /* as in gate_table */
};

/* A datagram without a slot; like gate_seen, with the latest sender. */
struct ether_seen {
	__u64 sequence;
	__u64 count;
	__u64 subject;
	__u32 len;
	__u8 direction;
	__u8 pad[3];
	__u64 station; /* its sender, see ether_station() */
	__u8 mac[6];   /* sender of the Ethernet frame; 0: not read */
	__u8 pad2[2];
};

/*
 * Like gate_sender; of a slot the reason is GATE_R_SOURCE. In slot 0 or 1, the subject is 0 if it
 * could not be read.
 */
struct ether_sender {
	__u64 sequence;
	__u64 count;
	__u64 subject;
	__u64 station; /* see ether_station() */
	__u32 slot;
	__u32 source; /* egress: ifindex that it entered by; 0: sent by a local program */
	__u32 uid;    /* egress: user of a local sender; otherwise GATE_ANY_UID */
	__u32 len;    /* payload bytes; in slot 0 or 1: bytes of the packet */
	__u8 mac[6];  /* sender of the Ethernet frame; 0: not read */
	__u8 direction;
	__u8 reason;
};

/* The counters of one CPU; there is one for each possible CPU. */
struct ether_cpu {
	__u64 reasons[GATE_DIRECTIONS][GATE_REASONS]; /* packets; each IP fragment counts */
	struct ether_seen seen[GATE_SEEN];
	struct ether_sender senders[GATE_SENDERS];
};

/* Identifies a datagram that is sent in IP fragments. */
struct ether_fragment_key {
	__u32 source; /* addresses and id in network byte order */
	__u32 destination;
	__u16 id;
	__u8 direction;
	__u8 inside; /* 1: it is inside a packet of a mesh protocol */
};

struct ether_fragment {
	__u64 until; /* CLOCK_MONOTONIC ns */
	__u64 subject;
	__s64 left; /* bytes that may still follow, so that all fragments together have no more than
		     * was announced */
	__u32 slot;
	__u16 first; /* bytes of the first fragment, which later ones must not overlay */
	__u16 whole; /* bytes of the datagram including its UDP header; 0: it is no event */
};

/*
 * Entries that a map needs to remember ETHER_FRAGMENTS datagrams. The kernel keeps complete
 * datagrams longer than new ones, and reserves entries on each CPU: four times as many entries just
 * suffice.
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
 * The station that a slot's frames come from: an IPv4 address; ETHER_MAC and a MAC address; or on
 * 802.15.4 ETHER_SHORT, PAN and short address, or ETHER_EXTENDED and the extended address. 0 is a
 * wildcard entry for stations without a slot of their own for that subject. When an event is
 * forwarded between two Ethernet-like interfaces, both slots have the same station, so that it is
 * the publisher in gate_origin().
 */
#define ETHER_MAC      (1ULL << 48)
#define ETHER_SHORT    (1ULL << 49)
#define ETHER_EXTENDED (1ULL << 56) /* the group bit, which no station's address has set */

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

/* The bits of a subject in the prefilter octet of its bucket: two, rarely one. */
static inline __u8 ether_prefilter_bits(__u64 hash)
{
	return (__u8)(1U << (hash >> 61) | 1U << (hash >> 56 & 7));
}

GATE_ASSERT(sizeof(struct ether_contract) == 64, "ether_contract is pinned layout");
GATE_ASSERT(sizeof(struct ether_slot) == 32, "ether_slot is pinned layout");
GATE_ASSERT(sizeof(struct ether_table) == 64 + 256, "ether_table is pinned layout");
GATE_ASSERT(sizeof(struct ether_seen) == 48, "ether_seen is pinned layout");
GATE_ASSERT(sizeof(struct ether_sender) == 56, "ether_sender is pinned layout");
GATE_ASSERT(sizeof(struct ether_cpu) == 256 + 48 * 64 + 56 * 64, "ether_cpu is pinned layout");
GATE_ASSERT(sizeof(struct ether_fragment_key) == 12, "a hash key has no holes");
GATE_ASSERT(sizeof(struct ether_fragment) == 32, "ether_fragment is pinned layout");

#endif
