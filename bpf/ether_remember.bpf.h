/* SPDX-License-Identifier: GPL-2.0-only OR BSD-2-Clause */
/*
 * IP fragments: only the first one has the subject. So the first fragments of datagrams are
 * remembered, separately for events and other UDP traffic, so that a flood of one cannot displace
 * the other.
 */
#ifndef MLCCA_ETHER_REMEMBER_BPF_H
#define MLCCA_ETHER_REMEMBER_BPF_H

#define FRAGMENT_MAP(name)                                                                         \
	struct {                                                                                   \
		__uint(type, BPF_MAP_TYPE_LRU_HASH);                                               \
		__uint(max_entries, 1); /* set before loading */                                   \
		__type(key, struct ether_fragment_key);                                            \
		__type(value, struct ether_fragment);                                              \
	} name SEC(".maps")

FRAGMENT_MAP(foreign_fragments);

static __always_inline struct ether_fragment *remembered(void *map,
							 const struct ether_fragment_key *key)
{
	struct ether_fragment *f = bpf_map_lookup_elem(map, key);

	return f && f->until > bpf_ktime_get_ns() ? f : NULL;
}

static __always_inline void remember(void *map, const struct event *e, __u32 slot)
{
	struct ether_fragment f = {.until = bpf_ktime_get_ns() + ETHER_FRAGMENT_NS,
				   .subject = e->subject,
				   .left = (__s64)e->whole - e->payload,
				   .slot = slot,
				   .first = e->payload,
				   .whole = e->whole};

	bpf_map_update_elem(map, &e->key, &f, BPF_ANY);
}

/* Whether a later fragment would overlay the first one. */
static __always_inline bool is_overlaid(const struct ether_fragment *f, const struct event *e)
{
	return e->offset < f->first;
}

#endif
