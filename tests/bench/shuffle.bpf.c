// SPDX-License-Identifier: GPL-2.0-only OR BSD-2-Clause
/*
 * For benches: gives each packet of a repeated test run another subject and calls what is measured,
 * so that no run finds the memory of the one before in a cache. `known`: subjects of a table.
 */
/* An order that the headers need. */
/* clang-format off */
#include <stdbool.h>
#include <linux/bpf.h>
#include <linux/if_ether.h>
#include <linux/pkt_cls.h>
#include <bpf/bpf_endian.h>
#include <bpf/bpf_helpers.h>
/* clang-format on */

#define SUBJECT_AT (ETH_HLEN + 20 + 8)

const volatile __u32 known_count = 0;
__u64 state = 1;

struct {
  __uint(type, BPF_MAP_TYPE_PROG_ARRAY);
  __uint(max_entries, 1);
  __type(key, __u32);
  __type(value, __u32);
} measured SEC(".maps");

struct {
  __uint(type, BPF_MAP_TYPE_ARRAY);
  __uint(map_flags, BPF_F_MMAPABLE);
  __uint(max_entries, 1 << 20);
  __type(key, __u32);
  __type(value, __u64);
} known SEC(".maps");

SEC("tc")
int shuffle(struct __sk_buff* skb) {
  void *data = (void*)(long)skb->data, *end = (void*)(long)skb->data_end;
  __u64 *subject = data + SUBJECT_AT, *one;
  __u32 at;

  if ((void*)(subject + 1) > end) return TC_ACT_SHOT;
  state = state * 6364136223846793005ULL + 1442695040888963407ULL;
  at = (state >> 32) * known_count >> 32;
  one = known_count ? bpf_map_lookup_elem(&known, &at) : 0;
  *subject = bpf_cpu_to_be64(one ? *one : state);
  skb->mark = 0;
  bpf_tail_call(skb, &measured, 0);
  return TC_ACT_UNSPEC;
}

char LICENSE[] SEC("license") = "Dual BSD/GPL";
