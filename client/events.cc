// SPDX-License-Identifier: BSD-2-Clause
// The C interface to the data plane (mlcca/client/events.h).
#include "mlcca/client/events.h"

#include <sys/epoll.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <functional>
#include <map>
#include <memory>
#include <new>
#include <span>
#include <string>
#include <string_view>

#include "client/data.hpp"
#include "control/codec.hpp"

using mlcca::Fd;
using mlcca::client::Channel;
using mlcca::client::Client;
using mlcca::client::Event;
using mlcca::client::Published;
namespace control = mlcca::control;

static_assert(MLCCA_TOO_LONG == static_cast<int>(Published::too_long));

struct __attribute__((visibility("hidden"))) mlcca_events {
  using Part = Channel::Part;
  using Handler = mlcca::client::SubscriberChannel::EventHandler;

  Fd epoll{::epoll_create1(EPOLL_CLOEXEC)};
  Client::Data data{epoll};
  std::string address;
  std::map<std::uint64_t, std::shared_ptr<Part>> ends;
  std::function<void(std::uint64_t end, const Event& event)>
      on_event;                      ///< set by mlcca_events_process()
  std::uint64_t without_memory = 0;  ///< how often events were lost because no memory was left

  std::vector<Client::Data::Happened> happened;  ///< not taken by the caller yet, in reverse order

  const std::shared_ptr<Part>& end(std::uint64_t number, mlcca_role role);
  std::string use(const std::shared_ptr<Part>& part, std::string_view reply);
};

const std::shared_ptr<Channel::Part>& mlcca_events::end(std::uint64_t number, mlcca_role role) {
  auto& part = ends[number];
  if (part) return part;
  part = std::make_shared<Part>();
  part->request.role =
      role == MLCCA_PUBLISHER ? control::Role::publisher : control::Role::subscriber;
  part->on_event = std::make_shared<const Handler>(
      [this, number](const Event& event) { on_event(number, event); });
  return part;
}

/// Returns what cannot be used, and why; empty if everything can.
std::string mlcca_events::use(const std::shared_ptr<Part>& part, std::string_view reply) {
  control::Buffer buffer;
  buffer.append(reply);
  const auto decoded = control::decode_reply(buffer);
  if (!decoded) return decoded.error().text;
  if (!*decoded || !buffer.content().empty()) return "what is given is not one reply";
  const auto done = data.use(part, **decoded);
  return done ? std::string() : done.error().text;
}

// No C++ exception may leave these functions. Without memory an event is lost, or nothing is
// granted to an endpoint.

mlcca_events* mlcca_events_new(void) {
  try {
    auto events = std::make_unique<mlcca_events>();
    return events->epoll ? events.release() : nullptr;
  } catch (const std::bad_alloc&) {
    return nullptr;
  }
}

void mlcca_events_free(mlcca_events* events) { delete events; }

int mlcca_events_fd(const mlcca_events* events) { return events->epoll.get(); }

const char* mlcca_events_address(mlcca_events* events, uint64_t end) {
  try {
    events->address = events->data.address(events->end(end, MLCCA_SUBSCRIBER));
  } catch (const std::bad_alloc&) {
    events->address.clear();
  }
  return events->address.c_str();
}

int mlcca_events_use(mlcca_events* events, uint64_t end, mlcca_role role, const void* reply,
                     size_t size, char* why, size_t why_size) {
  std::string wrong;
  try {
    wrong = events->use(events->end(end, role), {static_cast<const char*>(reply), size});
  } catch (const std::bad_alloc&) {
    mlcca_events_leave(events, end);
    wrong = "no memory";
  }
  if (why_size != 0) {
    const std::size_t length = std::min(wrong.size(), why_size - 1);
    wrong.copy(why, length);
    why[length] = '\0';
  }
  return wrong.empty() ? 0 : -1;
}

void mlcca_events_leave(mlcca_events* events, uint64_t end) { events->ends.erase(end); }

mlcca_published mlcca_events_publish(mlcca_events* events, uint64_t end, const void* data,
                                     size_t size) {
  const auto known = events->ends.find(end);
  if (known == events->ends.end()) return MLCCA_NOT_GRANTED;
  try {
    return static_cast<mlcca_published>(
        events->data.publish(known->second, {static_cast<const std::uint8_t*>(data), size}));
  } catch (const std::bad_alloc&) {
    return MLCCA_LOST;
  }
}

void mlcca_events_process(mlcca_events* events, mlcca_on_event on_event, void* context) {
  events->on_event = [on_event, context](std::uint64_t end, const Event& event) {
    using std::chrono::nanoseconds;
    const auto when = std::chrono::duration_cast<nanoseconds>(event.received.time_since_epoch());
    on_event(context, end, event.data, event.size, event.network,
             static_cast<std::uint64_t>(when.count()));
  };
  std::array<epoll_event, 16> ready{};
  const int count = ::epoll_wait(events->epoll.get(), ready.data(), ready.size(), 0);
  try {
    for (const epoll_event& one : std::span(ready).first(count < 0 ? 0 : count))
      static_cast<void>(events->data.receive(one.data.fd));
    events->data.call_handlers();
  } catch (const std::bad_alloc&) {
    ++events->without_memory;
  }
}

void mlcca_events_gone(mlcca_events* events, uint64_t since_ns) {
  try {
    for (const auto& [number, part] : events->ends) events->data.lose_daemon(part, since_ns);
  } catch (const std::bad_alloc&) {
    for (const auto& [number, part] : events->ends) events->data.close_local(part);
  }
}

void mlcca_events_close(mlcca_events* events, uint64_t end) {
  const auto known = events->ends.find(end);
  if (known != events->ends.end()) events->data.close_local(known->second);
}

size_t mlcca_events_happened(mlcca_events* events, uint64_t* end, void* reply, size_t size) {
  try {
    if (events->happened.empty()) {
      events->happened = events->data.take_happened();
      std::ranges::reverse(events->happened);
    }
    for (; !events->happened.empty(); events->happened.pop_back()) {
      const auto& [part, event] = events->happened.back();
      const auto known =
          std::ranges::find(events->ends, part, &decltype(events->ends)::value_type::second);
      if (known == events->ends.end()) continue;  // the endpoint was removed
      const std::string text = control::encode(control::Reply{.id = 0, .body = event});
      if (text.size() > size) return text.size();
      text.copy(static_cast<char*>(reply), text.size());
      *end = known->first;
      events->happened.pop_back();
      return text.size();
    }
  } catch (const std::bad_alloc&) {
    ++events->without_memory;
  }
  return 0;
}

uint64_t mlcca_events_lost_of(const mlcca_events* events, uint64_t end) {
  const auto known = events->ends.find(end);
  return known == events->ends.end() ? 0 : events->data.lost(known->second);
}

uint64_t mlcca_events_lost(const mlcca_events* events) {
  return events->data.lost() + events->without_memory;
}
