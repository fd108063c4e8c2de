// SPDX-License-Identifier: BSD-2-Clause
// Descriptions of a cluster as files in the state directory, each named by its digest, for its user
// only.
#pragma once
#include <optional>
#include <set>
#include <string>
#include <utility>

#include "daemon/outside/description_texts.hpp"

namespace mlcca {

class DescriptionFiles final : public DescriptionTexts {
 public:
  explicit DescriptionFiles(std::string directory) : directory_(std::move(directory)) {}

  Result<void> keep(const Digest& digest, const std::string& text) override;
  [[nodiscard]] std::optional<std::string> text(const Digest& digest) const override;
  void keep_only(const std::set<Digest>& digests) override;

 private:
  [[nodiscard]] std::string path_of(const Digest& digest) const;

  std::string directory_;
};

}  // namespace mlcca
