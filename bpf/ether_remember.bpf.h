/* SPDX-License-Identifier: GPL-2.0-only OR BSD-2-Clause */
/*
 * IP fragments: only the first one has the subject. It is remembered for each datagram, of events
 * and of other UDP traffic apart, so that a flood of the one cannot push out the other.
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

/* What a later fragment may not do to the first one. */
static __always_inline bool is_overlaid(const struct ether_fragment *f, const struct event *e)
{
	return e->offset < f->first;
}

#endif
