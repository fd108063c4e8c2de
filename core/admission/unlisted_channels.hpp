// SPDX-License-Identifier: BSD-2-Clause
#pragma once
#include <cstddef>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <vector>

#include "base/result.hpp"
#include "core/admission/unlisted.hpp"
#include "core/model/names.hpp"
#include "core/model/system.hpp"

namespace mlcca::core {

/// The unlisted channels of a gateway. Each takes one of the blank channels at the end of the
/// system, of which there are unlisted_room().
class UnlistedChannels {
 public:
  /// Whether a member uses the channel of that index, or did so until the next State::settle().
  using IsUsed = std::function<bool(std::size_t)>;

  /// Both must outlive this.
  UnlistedChannels(System& system, NameIndex& names) : system_(system), names_(names) {}

  /// See State::list(). `foreign` is indexed by network.
  [[nodiscard]] Result<std::size_t> list(const UnlistedChannel& wanted,
                                         const std::vector<cluster::Foreign>& foreign,
                                         const IsUsed& is_used);
  /// See State::unlist_unused().
  bool remove_unused(const IsUsed& is_used);

 private:
  [[nodiscard]] std::optional<std::size_t> free_index(const IsUsed& is_used) const;
  [[nodiscard]] Result<void> check_room(std::size_t channel, const UnlistedChannel& wanted,
                                        const IsUsed& is_used) const;
  [[nodiscard]] Result<void> check_same_identifiers(std::size_t channel,
                                                    const UnlistedChannel& wanted) const;
  void forget(std::size_t channel);

  System& system_;
  NameIndex& names_;
  /// Of each channel: the networks where it begins, ends or has an identifier.
  std::map<std::size_t, std::set<std::size_t>> networks_;
};

}  // namespace mlcca::core
