/* SPDX-License-Identifier: BSD-2-Clause */
/* The events of a program's channels in C, for libraries in other languages that speak with mlccad
 * themselves (mlcca/v1/control.proto): the sockets that events go by, as mlcca::client has them.
 *
 *   struct mlcca_events* events = mlcca_events_new();
 *   announce.local = mlcca_events_address(events, 1);          // of a subscriber
 *   mlcca_events_use(events, 1, MLCCA_SUBSCRIBER, reply, size, why, sizeof why);
 *   mlcca_events_use(events, 2, MLCCA_PUBLISHER, reply, size, why, sizeof why);
 *   mlcca_events_publish(events, 2, "go", 2);
 *
 * What belongs to one `struct mlcca_events` belongs to one thread. Nothing here waits. */
#ifndef MLCCA_CLIENT_EVENTS_H
#define MLCCA_CLIENT_EVENTS_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#define MLCCA_API __attribute__((visibility("default")))

struct mlcca_events;

enum mlcca_role { MLCCA_PUBLISHER = 0, MLCCA_SUBSCRIBER = 1 };

/* What became of an event that was published: mlcca::client::Published has the meanings. */
enum mlcca_published {
  MLCCA_SENT = 0,
  MLCCA_PARTLY = 1,
  MLCCA_LOST = 2,
  MLCCA_NOT_GRANTED = 3,
  MLCCA_TOO_LONG = 4
};

/* NULL: there are no file descriptors or no memory left. */
MLCCA_API struct mlcca_events* mlcca_events_new(void);
MLCCA_API void mlcca_events_free(struct mlcca_events* events);

/* Can be read when mlcca_events_process() has something to do. It stays the same. */
MLCCA_API int mlcca_events_fd(const struct mlcca_events* events);

/* For AnnounceRequest.local of a subscriber; valid until the next call. Who knows it can send to
 * this end: it is for the daemon alone, which gives it to granted publishers. After
 * mlcca_events_use() it may be another one, since a publisher has lost its grant or since two ends
 * have one channel: announce once more then. Empty: there are no file descriptors left, and events
 * of programs on the gateway do not come. */
MLCCA_API const char* mlcca_events_address(struct mlcca_events* events, uint64_t end);

/* An end of a channel, by a number that the caller chooses, sends or receives as the daemon has
 * answered from now on. `reply`: a mlcca.v1.Reply with `channels`, behind its length as a varint;
 * of an error, or of a reply without endpoints, the end is granted nothing. Of each of its channels
 * subject, publisher, from, to and granted are read. The numbers of an end
 * keep their role. 0: done. -1: the text at `why` says what cannot be used; what can be is. */
MLCCA_API int mlcca_events_use(struct mlcca_events* events, uint64_t end, enum mlcca_role role,
                               const void* reply, size_t size, char* why, size_t why_size);
/* The end is gone. */
MLCCA_API void mlcca_events_leave(struct mlcca_events* events, uint64_t end);

/* An event of 0 to 65,535 bytes. */
MLCCA_API enum mlcca_published mlcca_events_publish(struct mlcca_events* events, uint64_t end,
                                                    const void* data, size_t size);

/* `network`: that the event came from; empty: from a program on the gateway. `unix_ns`: when the
 * kernel received it, nanoseconds since 1970. What is pointed to is valid during the call. */
typedef void (*mlcca_on_event)(void* context, uint64_t end, const void* data, size_t size,
                               const char* network, uint64_t unix_ns);
/* Takes what has come, at most 64 events of each socket, and calls `on_event` for each. That must
 * not call back into `events`. */
MLCCA_API void mlcca_events_process(struct mlcca_events* events, mlcca_on_event on_event,
                                    void* context);

/* What has happened to events of programs on the gateway, which no gate supervises: call it after
 * mlcca_events_process() until it returns 0. It writes one mlcca.v1.Reply with an `event` of kind
 * missing, restored, excess or missed, behind its length as a varint, and the end that it is of.
 * The size of it; where that is more than `size` nothing is written, and it stays. */
MLCCA_API size_t mlcca_events_happened(struct mlcca_events* events, uint64_t* end, void* reply,
                                       size_t size);

/* Frames and events that came and were incomplete, malformed, or lost in a socket, and those for
 * which there was no memory, counted once for each call that had none. Of programs on the gateway
 * those that are longer than the channel's MaxPayload, or more than is admitted, or missed. */
MLCCA_API uint64_t mlcca_events_lost(const struct mlcca_events* events);

#ifdef __cplusplus
}
#endif

#endif /* MLCCA_CLIENT_EVENTS_H */
