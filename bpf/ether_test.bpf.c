// SPDX-License-Identifier: GPL-2.0-only OR BSD-2-Clause
/* The gate of one Ethernet-like interface, for BPF_PROG_TEST_RUN; it is never attached. */
#include <stdbool.h>
#include <stddef.h>
#include <linux/batadv_packet.h>
#include <linux/bpf.h>
#include <linux/can.h>
#include <linux/if_ether.h>
#include <linux/if_packet.h>
#include <linux/in.h>
#include <linux/ip.h>
#include <linux/pkt_cls.h>
#include <linux/udp.h>
#include <bpf/bpf_endian.h>
#include <bpf/bpf_helpers.h>

#include "bpf/test_skb.bpf.h"
#include "bpf/ether_body.bpf.h"

char LICENSE[] SEC("license") = "Dual BSD/GPL";
