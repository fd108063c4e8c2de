// SPDX-License-Identifier: BSD-2-Clause
// Descriptions that a cluster has had in force, or is to have, as an interface: files, or a fake.
#pragma once
#include <functional>
#include <optional>
#include <set>
#include <string>

#include "base/result.hpp"
#include "base/sha256.hpp"

namespace mlcca {

/// A description that was kept.
struct KeptText {
  std::optional<std::string> text;  ///< of the digest that was asked for
  std::string damage;               ///< why it is not that, although it is there
};

class DescriptionTexts {
 public:
  using Digest = Sha256::Digest;
  using Reader = std::function<KeptText(const Digest&)>;

  DescriptionTexts() = default;
  DescriptionTexts(const DescriptionTexts&) = delete;
  DescriptionTexts& operator=(const DescriptionTexts&) = delete;
  DescriptionTexts(DescriptionTexts&&) = delete;
  DescriptionTexts& operator=(DescriptionTexts&&) = delete;
  virtual ~DescriptionTexts() = default;

  /// It outlives a loss of power from then on. Refused where the digest is another one.
  virtual Result<void> keep(const Digest& digest, const std::string& text) = 0;
  /// Reads, on any thread, also after the daemon has let go of it.
  [[nodiscard]] virtual Reader reader() const = 0;
  /// Others are not needed any more.
  virtual void keep_only(const std::set<Digest>& digests) = 0;
};

}  // namespace mlcca
