// SPDX-License-Identifier: BSD-2-Clause
#include "core/design/hints.hpp"

#include "core/profiles/profile.hpp"

namespace mlcca::core {

std::string queue_hint(std::uint64_t frames, const std::string& why) {
  constexpr std::uint64_t most = 10'000;  // the largest value of the schema
  const std::string less = "send less often, or smaller events";
  const std::string needed = std::to_string(frames);
  if (frames > most)
    return less + ": the queue would have to hold " + needed + " frames, and " +
           std::to_string(most) + " are the most";
  return less + ", or give the port of the gateway queue-length=\"" + needed + "\": " + why;
}

std::string address_words(const std::string& a, const std::string& b, std::uint32_t sender,
                          const std::string& network) {
  constexpr std::uint32_t address = 0xff;  // the address bits of can::Message::sender
  return a + " and " + b + " claim one address on " + network + ", " +
         std::to_string(sender & address) + ": no bound holds there";
}

std::string sender_hint(Profile profile) {
  const std::string hint =
      "let the events reach the bus once: over one gateway, or by the publisher";
  return has_nodes(profile) ? hint + "; or give each publisher a node of its own" : hint;
}

}  // namespace mlcca::core
