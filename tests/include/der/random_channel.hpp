// SPDX-License-Identifier: BSD-2-Clause
// Random channels that have an encoding.
#pragma once
#include <algorithm>
#include <string>
#include <vector>

#include "mlcca/der.hpp"
#include "tests/include/random_world.hpp"

namespace mlcca::testing {

class RandomChannel {
 public:
  explicit RandomChannel(RandomWorld& world) {
    const auto role = static_cast<der::Role>(world.below(der::kRoles));
    const bool network = role == der::Role::network;
    const unsigned dynamic = network ? 3 : RandomWorld::kNever;
    channel_.role = role;
    channel_.subject = network && world.one_in(2) ? 0 : std::max<Value>(world.value(), 1);
    for (std::size_t i = 0; i < kAttributes; ++i)
      if (world.one_in(2))
        channel_.attributes.set(attribute_at(i), edge(world), world.one_in(dynamic));
    if (world.one_in(2)) add_users(world, dynamic);
  }

  /// Valid as long as this object.
  [[nodiscard]] const der::Channel& get() const { return channel_; }
  [[nodiscard]] std::vector<std::uint8_t> encoded() const {
    std::vector<std::uint8_t> octets(der::encoded_size(channel_));
    octets.resize(der::encode(channel_, octets.data(), octets.size()));
    return octets;
  }

  RandomChannel(const RandomChannel&) = delete;
  RandomChannel& operator=(const RandomChannel&) = delete;
  RandomChannel(RandomChannel&&) = delete;
  RandomChannel& operator=(RandomChannel&&) = delete;
  ~RandomChannel() = default;

 private:
  /// Where an INTEGER grows by an octet, or any number.
  static Value edge(RandomWorld& world) {
    static constexpr Value edges[] = {
        0, 1, 127, 128, 255, 256, 32767, 32768, 65535, 65536, Value{1} << 63, kUnbounded};
    return world.one_in(2) ? edges[world.below(std::size(edges))] : world.value();
  }

  static std::string name(RandomWorld& world) {
    static constexpr const char* parts[] = {"Temperature", "a",          "Z", "_", "\u00e9",
                                            "\u20ac",      "\U0001f916", "0", "zz"};
    std::string name;
    for (std::size_t left = 1 + world.below(5); left != 0; --left)
      name += parts[world.below(std::size(parts))];
    return name;
  }

  void add_users(RandomWorld& world, unsigned dynamic) {
    for (std::size_t left = 1 + world.below(der::kMaxUserAttributes); left != 0; --left)
      names_.push_back(name(world));
    std::ranges::sort(names_);
    names_.erase(std::ranges::unique(names_).begin(), names_.end());
    for (const std::string& n : names_)
      users_.emplace_back(n.data(), n.size(), edge(world), world.one_in(dynamic));
    channel_.user = users_.data();
    channel_.users = users_.size();
  }

  std::vector<std::string> names_;
  std::vector<der::UserAttribute> users_;
  der::Channel channel_;
};

}  // namespace mlcca::testing
