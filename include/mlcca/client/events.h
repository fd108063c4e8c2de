/* SPDX-License-Identifier: BSD-2-Clause */
/* The events of a program's channels in C, for libraries in other languages that implement the
 * control protocol with mlccad (mlcca/v1/control.proto) themselves. It owns the sockets that
 * carry the events, as mlcca::client does.
 *
 *   struct mlcca_events* events = mlcca_events_new();
 *   announce.local = mlcca_events_address(events, 1);          // of a subscriber
 *   mlcca_events_use(events, 1, MLCCA_SUBSCRIBER, reply, size, why, sizeof why);
 *   mlcca_events_use(events, 2, MLCCA_PUBLISHER, reply, size, why, sizeof why);
 *   mlcca_events_publish(events, 2, "go", 2);
 *
 * A `struct mlcca_events` is not thread-safe: use it from one thread. No function waits, and none
 * throws. */
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

/* The result of publishing an event, with the meanings of mlcca::client::Published. */
enum mlcca_published {
  MLCCA_SENT = 0,
  MLCCA_PARTLY = 1,
  MLCCA_LOST = 2,
  MLCCA_NOT_GRANTED = 3,
  MLCCA_TOO_LONG = 4
};

/* Returns NULL if no file descriptors or no memory are left. Free it with mlcca_events_free(). */
MLCCA_API struct mlcca_events* mlcca_events_new(void);
MLCCA_API void mlcca_events_free(struct mlcca_events* events);

/* A file descriptor that is readable when mlcca_events_process() has work to do. It is the same
 * for the lifetime of `events`, which owns it. */
MLCCA_API int mlcca_events_fd(const struct mlcca_events* events);

/* The address for AnnounceRequest.local of a subscriber; the text is valid until the next call.
 * It contains a key that allows to send to this endpoint, so pass it to the daemon only, which
 * hands it to granted publishers. mlcca_events_use() may change it, because a publisher has lost
 * its grant or because two endpoints have the same channel: compare it after each such call, and
 * announce again if it differs. Empty: no file descriptors are left, and events of programs on
 * the gateway do not arrive. */
MLCCA_API const char* mlcca_events_address(struct mlcca_events* events, uint64_t end);

/* Makes the endpoint `end`, a number that the caller chooses, send or receive as the daemon has
 * answered. `reply`: one mlcca.v1.Reply with `channels`, preceded by its length as a varint; with
 * an error, or without endpoints, nothing is granted to the endpoint. Of each channel only
 * subject, publisher, from, to and granted are read, and of the reply grace_ns. A number keeps the
 * role of its first call. Returns 0, or -1 if something cannot be used: the text at `why`, cut to
 * `why_size`, says what, and the rest is in use. */
MLCCA_API int mlcca_events_use(struct mlcca_events* events, uint64_t end, enum mlcca_role role,
                               const void* reply, size_t size, char* why, size_t why_size);
/* The daemon is gone since `since_ns` (CLOCK_MONOTONIC): the connection is lost, or it does not
 * answer. Events between programs on the gateway, which pass no gate, go on for the grace that the
 * daemon has stated in its replies (10 s if none did). Then they are neither sent nor delivered,
 * and mlcca_events_happened() reports `lapsed` for each endpoint that had something granted. The
 * next mlcca_events_use() of an endpoint opens it again. Without this call they go on without end.
 * A later time than that of an earlier call changes nothing. */
MLCCA_API void mlcca_events_gone(struct mlcca_events* events, uint64_t since_ns);
/* The endpoint neither sends nor delivers events between programs on the gateway any more, until
 * mlcca_events_use() is called for it. To be called for each endpoint when the daemon has sent the
 * event `stopped`, and for one whose deliveries on the gateway are withdrawn. */
MLCCA_API void mlcca_events_close(struct mlcca_events* events, uint64_t end);
/* Removes the endpoint. Its number may be used again. */
MLCCA_API void mlcca_events_leave(struct mlcca_events* events, uint64_t end);

/* Sends an event of 0 to 65,535 bytes. Returns MLCCA_NOT_GRANTED for an unknown endpoint. */
MLCCA_API enum mlcca_published mlcca_events_publish(struct mlcca_events* events, uint64_t end,
                                                    const void* data, size_t size);

/* Called for each event. `network`: where it came from; empty if a program on the gateway sent
 * it. `unix_ns`: when the kernel received it, in ns since 1970. The pointers are valid during the
 * call. */
typedef void (*mlcca_on_event)(void* context, uint64_t end, const void* data, size_t size,
                               const char* network, uint64_t unix_ns);
/* Receives the pending events, at most 64 from each socket, and calls `on_event` for each.
 * `on_event` must not call any function with `events`. */
MLCCA_API void mlcca_events_process(struct mlcca_events* events, mlcca_on_event on_event,
                                    void* context);

/* Reports what has happened to events of programs on the gateway, which pass no gate that
 * supervises them. Call it after mlcca_events_process() until it returns 0. It writes one
 * mlcca.v1.Reply with an `event` of kind missing, restored, policed, missed or lapsed, preceded by
 * its length as a varint, and the number of the endpoint at `end`. Returns the size of the reply;
 * if that exceeds `size`, nothing is written and the reply is kept for the next call. */
MLCCA_API size_t mlcca_events_happened(struct mlcca_events* events, uint64_t* end, void* reply,
                                       size_t size);

/* How much was lost on the way to one endpoint: its own events of programs on the gateway, and
 * everything that was lost on the networks from which it receives while it does, because the
 * endpoints of a network share a socket. 0 for an unknown endpoint. */
MLCCA_API uint64_t mlcca_events_lost_of(const struct mlcca_events* events, uint64_t end);
/* How much was lost since `events` was made, of all endpoints, each loss counted once: frames and
 * events that were incomplete, malformed or lost in a socket; events of programs on the gateway
 * that were longer than the channel's MaxPayload, exceeded what is admitted, or were missed; and
 * one for each call that ran out of memory. */
MLCCA_API uint64_t mlcca_events_lost(const struct mlcca_events* events);

#ifdef __cplusplus
}
#endif

#endif /* MLCCA_CLIENT_EVENTS_H */
