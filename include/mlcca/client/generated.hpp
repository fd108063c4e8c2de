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

/// Calls the exception handler of a specification with the generated reason that corresponds to the
/// cause. The causes mode, lagged and other have no such reason and are ignored.
template <class Spec>
void call_handler(const Exception& exception) {
  using Why = WhyOf<Spec>;
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
    on_event([](const Event& event) { Spec::notify(event.data, event.size); });
  }
};

}  // namespace mlcca::client
