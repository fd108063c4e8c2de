/* SPDX-License-Identifier: GPL-2.0-only OR BSD-2-Clause */
/* The part of gate.h for J1939's transport protocol; it belongs to the same layout version. */
#ifndef MLCCA_GATE_TRANSPORT_H
#define MLCCA_GATE_TRANSPORT_H

#include <linux/types.h>

/*
 * SAE J1939-21, 5.10: a message of more than 8 bytes is announced by a frame of PGN 0xEC00 (TP.CM)
 * and follows in packets of PGN 0xEB00 (TP.DT). Byte 0 of TP.CM is its kind. In a broadcast
 * announcement (BAM) and a request to send (RTS), bytes 1 and 2 are the size of the message, byte 3
 * is the number of its packets, and bytes 5 to 7 are its PGN, all with the low byte first. Byte 0
 * of TP.DT is the number of the packet, from 1 on; the other bytes belong to the message.
 */
#define GATE_TP_PGN_MASK    0x03ff0000U /* masks an identifier */
#define GATE_TP_CM	    0x00ec0000U
#define GATE_TP_DT	    0x00eb0000U
#define GATE_TP_BROADCAST   0x0000ff00U
#define GATE_TP_DESTINATION 0x0000ff00U
#define GATE_TP_SOURCE	    0x000000ffU
#define GATE_TP_PRIORITY    0x1c000000U
#define GATE_TP_RTS	    16
#define GATE_TP_BAM	    32
#define GATE_TP_PACKET	    7 /* bytes of the message in a packet */
#define GATE_TP_LEAST	    9 /* bytes of a message; shorter ones are sent in one frame */
#define GATE_TP_MOST	    1785
#define GATE_TP_SOURCES	    256
/* T1 in ns: after this time without the next packet a receiver gives the message up. */
#define GATE_TP_TIMEOUT 750000000ULL

/*
 * A message that a source address has announced and that was admitted, in one direction of one
 * gate. The state changes as one word, so that no packet passes twice, whatever other CPUs do. It
 * has the identifier that a frame of the message's PGN would have, without flags and priority (the
 * low 32 bits), the slot (12 bits), the number of packets and the number of the next one (8 bits
 * each). 0: there is no message.
 */
struct gate_session {
	__u64 state;
	__u64 latest; /* CLOCK_MONOTONIC ns of its latest frame */
};

#endif
