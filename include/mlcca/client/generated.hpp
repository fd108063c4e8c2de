// SPDX-License-Identifier: BSD-2-Clause
// Channels for the specifications that `mlccactl generate` makes of a description: events and
// exceptions of a channel call the handlers of its specification. For example, with the generated
// namespace workshop::panel:
//
//   mlcca::client::Client client;
//   mlcca::client::GeneratedSubscriber<workshop::panel::MotorSpec> motor(client);
//   motor.subscribe();
//   for (;;) client.wait(std::chrono::seconds(1));
//
// C++17 with the standard library.
#pragma once
#include <cstdint>
#include <string>
#include <utility>

#include "mlcca/client/client.hpp"

namespace mlcca::client {
namespace detail {

/// Deduces the enum that the exception handler of a specification takes.
template <class Why>
Why why_of(void (*handler)(Why));
template <class Spec>
using WhyOf = decltype(why_of(&Spec::exception));

inline std::string subject_text(std::uint64_t subject) {
  std::string out = "0x0000000000000000";
  for (auto digit = out.rbegin(); subject != 0; ++digit, subject >>= 4U)
    *digit = "0123456789abcdef"[subject & 0xfU];
  return out;
}

/// What the handlers of a specification are called for now, in this thread; null outside of them.
template <class Spec>
inline thread_local const Exception* handled_exception = nullptr;
template <class Spec>
inline thread_local const Event* handled_event = nullptr;

/// Sets one of these as long as a handler runs, also if it throws.
template <class What>
class Handled {
 public:
  Handled(const What*& place, const What& what) : place_(place), before_(place) { place = &what; }
  Handled(const Handled&) = delete;
  Handled& operator=(const Handled&) = delete;
  Handled(Handled&&) = delete;
  Handled& operator=(Handled&&) = delete;
  ~Handled() { place_ = before_; }

 private:
  const What*& place_;
  const What* before_;
};

template <class Spec>
void call_event_handler(const Event& event) {
  const Handled<Event> handled(handled_event<Spec>, event);
  Spec::notify(event.data, event.size);
}

/// Calls the exception handler of a specification with the generated reason that corresponds to the
/// cause. The causes mode, lagged and other have no such reason and are ignored.
template <class Spec>
void call_handler(const Exception& exception) {
  using Why = WhyOf<Spec>;
  const Handled<Exception> handled(handled_exception<Spec>, exception);
  switch (exception.cause) {
    case Cause::refused:
    case Cause::rejected:
      Spec::exception(Why::refused);
      break;
    case Cause::withdrawn:
    case Cause::network_down:
    case Cause::gates_closed:
      Spec::exception(Why::withdrawn);
      break;
    case Cause::degraded:
    case Cause::upgraded:
      Spec::exception(Why::switched);
      break;
    case Cause::policed:
    case Cause::dropped:
    case Cause::missing:
    case Cause::missed:
    case Cause::late:
      Spec::exception(Why::violated);
      break;
    case Cause::granted:
      Spec::exception(Why::granted);
      break;
    case Cause::restored:
      Spec::exception(Why::restored);
      break;
    case Cause::daemon_gone:
      Spec::exception(Why::unknown);
      break;
    case Cause::daemon_back:
      Spec::exception(Why::known);
      break;
    case Cause::mode:
    case Cause::lagged:
    case Cause::other:
      break;
  }
}

}  // namespace detail

/// The exception with its cause and numbers, for the code in Spec::exception(). Null if this thread
/// runs no such handler.
template <class Spec>
const Exception* exception_of() {
  return detail::handled_exception<Spec>;
}
/// The event with its network and time, for the code in Spec::notify(). Null outside of it.
template <class Spec>
const Event* event_of() {
  return detail::handled_event<Spec>;
}

/// A publisher for a specification with exception(). `name`: the publisher's name in the
/// description; needed if the user that runs this program has several publishers of the channel.
template <class Spec>
class GeneratedPublisher : public PublisherChannel {
 public:
  explicit GeneratedPublisher(Client& client, std::string name = {})
      : PublisherChannel(client, detail::subject_text(Spec::subject),
                         values_of<typename Spec::attributes>(), std::move(name)) {
    on_exception(detail::call_handler<Spec>);
  }
};

/// A subscriber for a specification with notify() and exception(). `name`: as for
/// GeneratedPublisher.
template <class Spec>
class GeneratedSubscriber : public SubscriberChannel {
 public:
  explicit GeneratedSubscriber(Client& client, std::string name = {})
      : SubscriberChannel(client, detail::subject_text(Spec::subject),
                          values_of<typename Spec::attributes>(), std::move(name)) {
    on_exception(detail::call_handler<Spec>);
    on_event(detail::call_event_handler<Spec>);
  }
};

}  // namespace mlcca::client
