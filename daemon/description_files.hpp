// SPDX-License-Identifier: BSD-2-Clause
// Keeps descriptions of a cluster as files in the state directory. Each file is named by its
// digest, and only its user may read it.
#pragma once
#include <set>
#include <string>
#include <utility>

#include "daemon/outside/description_texts.hpp"

namespace mlcca {

class DescriptionFiles final : public DescriptionTexts {
 public:
  explicit DescriptionFiles(std::string directory) : directory_(std::move(directory)) {}

  Result<void> keep(const Digest& digest, const std::string& text) override;
  [[nodiscard]] Reader reader() const override;
  void keep_only(const std::set<Digest>& digests) override;

 private:
  std::string directory_;
};

}  // namespace mlcca
