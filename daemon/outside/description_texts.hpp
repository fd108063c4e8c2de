// SPDX-License-Identifier: BSD-2-Clause
// Descriptions that a cluster has had in force, or is to have, as an interface: files, or a fake.
#pragma once
#include <optional>
#include <set>
#include <string>

#include "base/result.hpp"
#include "base/sha256.hpp"

namespace mlcca {

class DescriptionTexts {
 public:
  using Digest = Sha256::Digest;

  DescriptionTexts() = default;
  DescriptionTexts(const DescriptionTexts&) = delete;
  DescriptionTexts& operator=(const DescriptionTexts&) = delete;
  DescriptionTexts(DescriptionTexts&&) = delete;
  DescriptionTexts& operator=(DescriptionTexts&&) = delete;
  virtual ~DescriptionTexts() = default;

  /// It outlives a loss of power from then on.
  virtual Result<void> keep(const Digest& digest, const std::string& text) = 0;
  /// Nothing: it is not there, or cannot be read. It may be damaged.
  [[nodiscard]] virtual std::optional<std::string> text(const Digest& digest) const = 0;
  /// Others are not needed any more.
  virtual void keep_only(const std::set<Digest>& digests) = 0;
};

}  // namespace mlcca
