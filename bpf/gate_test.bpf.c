// SPDX-License-Identifier: GPL-2.0-only OR BSD-2-Clause
/* The gate of one CAN interface, for BPF_PROG_TEST_RUN; it is never attached. */
#include <stdbool.h>
#include <linux/bpf.h>
#include <linux/can.h>
#include <linux/if_ether.h>
#include <linux/pkt_cls.h>
#include <bpf/bpf_endian.h>
#include <bpf/bpf_helpers.h>

#include "bpf/test_skb.bpf.h"
#include "bpf/gate_body.bpf.h"

char LICENSE[] SEC("license") = "Dual BSD/GPL";
