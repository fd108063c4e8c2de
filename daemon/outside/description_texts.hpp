// SPDX-License-Identifier: BSD-2-Clause
// An interface for the texts of descriptions that a cluster has had or will have in force: files,
// or a fake.
#pragma once
#include <functional>
#include <optional>
#include <set>
#include <string>

#include "base/result.hpp"
#include "base/sha256.hpp"

namespace mlcca {

/// The result of reading a kept description.
struct KeptText {
  std::optional<std::string> text;  ///< the text with the requested digest; nullopt: there is none
  std::string damage;               ///< why an existing text cannot be used; empty: no damage
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

  /// Keeps a text durably, also over a loss of power. Refused if the text has another digest.
  virtual Result<void> keep(const Digest& digest, const std::string& text) = 0;
  /// A function that reads texts, on any thread, also after this object is gone.
  [[nodiscard]] virtual Reader reader() const = 0;
  /// Removes all other texts.
  virtual void keep_only(const std::set<Digest>& digests) = 0;
};

}  // namespace mlcca
