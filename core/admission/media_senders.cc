// SPDX-License-Identifier: BSD-2-Clause
// Who sends the frames of a message on a bus: in which queue they wait, and how long the sender
// pauses between them.
#include "core/admission/media.hpp"
#include "core/model/carrier.hpp"
#include "core/model/medium.hpp"

namespace mlcca::core {
namespace {

constexpr unsigned kAddressBits = 8;  // width of an address in can::Message::sender

}  // namespace

/// The pauses of the sender between the frames of an event, in ns; 0 if the kernel forwards the
/// frames. A stated provision is one of single frames, so the pauses are added to it.
Value Media::pauses_at(std::size_t hop) const {
  if (is_forwarded(s_.system, places_, hop)) return 0;
  const Network& network = s_.system.networks[places_[hop].index];
  const AttributeSet& offered = attributes_in(s_.members.publisher(v_.publisher), v_.set);
  return pauses_of(network, network.binding_of(v_.channel), offered[Attribute::max_payload]);
}

std::uint32_t Media::sender_queue(std::size_t hop) const {
  const Place sender = hop > 0 ? places_[hop - 1] : v_.route.front();
  if (sender.kind != Place::Kind::gateway) return can::kOwnQueue;
  return queue_of(s_.system, sender.index, places_[hop].index);
}

/// Sets the message's sender to the owner of the source address on that bus: a node, mlcca-relay, a
/// program of a user, or the bus from which the kernel forwards. In the last case the pauses are
/// already part of the jitter.
void Media::name_sender(std::size_t hop, const Publisher& publisher, can::Message& message) const {
  constexpr std::uint32_t of_user = 1U << 31U;
  std::uint32_t who = 0;
  if (is_forwarded(s_.system, places_, hop)) {
    message.pauses = 0;
    who = static_cast<std::uint32_t>(places_[hop - 2].index + 1) << kAddressBits;
  } else if (hop == 0 && publisher.place.kind == Place::Kind::gateway) {
    who = of_user | publisher.uid.value_or(0) << kAddressBits;
  }
  message.sender |= who;
}

}  // namespace mlcca::core
