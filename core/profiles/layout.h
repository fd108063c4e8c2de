/* SPDX-License-Identifier: GPL-2.0-only OR BSD-2-Clause */
/*
 * How the frames of each profile name their channel, for the programs of the kernel and for user
 * space: which part of an identifier is the key, and in which bucket it is. list.inc lists the
 * profiles.
 */
#ifndef MLCCA_PROFILE_LAYOUT_H
#define MLCCA_PROFILE_LAYOUT_H

#include <linux/can.h>
#include <linux/types.h>

/* NOLINTBEGIN(performance-enum-size,readability-identifier-naming,misc-const-correctness): C */
enum gate_profile {
#define PROFILE(word, NAME) GATE_PROFILE_##NAME,
#include "core/profiles/list.inc"
};

/*
 * Buckets of one direction. An 11-bit identifier is the number of its bucket; a 29-bit one (raw) or
 * a PGN (j1939) is hashed to the 14-bit range after them. An etag (famouso) or subject-id (cyphal)
 * is the number of its bucket.
 */
#define GATE_STANDARD_BUCKETS 2048
#define GATE_HASH_BITS 14
#define GATE_BUCKETS (GATE_STANDARD_BUCKETS + (1 << GATE_HASH_BITS))
#define GATE_NO_BUCKET 0xffffffffU
#define GATE_ETAG_MASK 0x3fffU

/*
 * SAE J1939-21: priority, extended data page, data page, PDU format, PDU specific, source address.
 * The PGN is everything between priority and source; for PDU formats below 240 (PDU1), PDU specific
 * is the destination and not part of it.
 */
#define GATE_J1939_PDU1_KEY 0x03ff0000U
#define GATE_J1939_PDU2_KEY 0x03ffff00U
#define GATE_J1939_PDU2 0x00f00000U /* all set for PDU formats from 240 on */

/*
 * Cyphal/CAN 1.0: priority, service, anonymous, reserved (0), two bits that receivers ignore,
 * subject-id, reserved (0), source. Service frames and frames with a reserved bit have no key.
 */
#define GATE_CYPHAL_KEY 0x001fff00U
#define GATE_CYPHAL_SHIFT 8
#define GATE_CYPHAL_FOREIGN (1U << 25 | 1U << 23 | 1U << 7)

/*
 * The part of an identifier that is the key; 0 if the profile has no subject for it. Frames with
 * other keys can share a bucket.
 */
static inline __u32 gate_key_mask(__u32 profile, __u32 can_id) {
  if (profile == GATE_PROFILE_RAW) return CAN_EFF_FLAG | CAN_EFF_MASK;
  if (profile == GATE_PROFILE_CANOPEN)
    return (can_id & CAN_EFF_FLAG) ? 0 : CAN_EFF_FLAG | CAN_EFF_MASK;
  if (!(can_id & CAN_EFF_FLAG)) return 0;
  if (profile == GATE_PROFILE_FAMOUSO) return CAN_EFF_FLAG | GATE_ETAG_MASK;
  if (profile == GATE_PROFILE_J1939)
    return CAN_EFF_FLAG | ((can_id & GATE_J1939_PDU2) == GATE_J1939_PDU2 ? GATE_J1939_PDU2_KEY
                                                                         : GATE_J1939_PDU1_KEY);
  if (profile == GATE_PROFILE_CYPHAL && !(can_id & GATE_CYPHAL_FOREIGN))
    return CAN_EFF_FLAG | GATE_CYPHAL_KEY;
  return 0;
}

/* The bucket of a frame or slot; GATE_NO_BUCKET if the profile has no subject for it. */
static inline __u32 gate_bucket(__u32 profile, __u32 can_id) {
  __u32 key_mask = gate_key_mask(profile, can_id);

  if (!key_mask) return GATE_NO_BUCKET;
  if (profile == GATE_PROFILE_FAMOUSO) return can_id & GATE_ETAG_MASK;
  if (profile == GATE_PROFILE_CYPHAL) return (can_id & GATE_CYPHAL_KEY) >> GATE_CYPHAL_SHIFT;
  if (!(can_id & CAN_EFF_FLAG)) return can_id & CAN_SFF_MASK;
  /* Multiplication by 2^32 over the golden ratio spreads neighbours. */
  return GATE_STANDARD_BUCKETS +
         (((can_id & key_mask & CAN_EFF_MASK) * 0x9e3779b1U) >> (32 - GATE_HASH_BITS));
}

/* Whether slots may leave a part of the key open. */
static inline int gate_has_masks(__u32 profile) {
  return profile == GATE_PROFILE_RAW || profile == GATE_PROFILE_CANOPEN;
}

/* Whether a transport protocol with identifiers of its own carries longer events. */
static inline int gate_has_transport(__u32 profile) { return profile == GATE_PROFILE_J1939; }

/* Whether identifiers contain a destination, which a slot may state. */
static inline int gate_has_destinations(__u32 profile) { return profile == GATE_PROFILE_J1939; }

/* Whether a broker assigns the keys at run time. */
static inline int gate_has_broker(__u32 profile) { return profile == GATE_PROFILE_FAMOUSO; }
/* NOLINTEND(performance-enum-size,readability-identifier-naming,misc-const-correctness) */

#endif
