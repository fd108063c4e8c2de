// SPDX-License-Identifier: BSD-2-Clause
// Who sends the frames of a message on a bus: in which queue they wait, and how long the sender
// pauses between them.
#include "core/admission/media.hpp"
#include "core/model/carrier.hpp"
#include "core/model/medium.hpp"

namespace mlcca::core {
namespace {

constexpr unsigned kAddressBits = 8;  // of can::Message::sender

}  // namespace

/// What is stated is of frames: the sender's pauses come on top.
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

/// Who has the address there: a node, mlcca-relay, a program of a user, or those of another bus,
/// whose frames leave as they come: the pauses between them are in the jitter.
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
