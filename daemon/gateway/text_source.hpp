// SPDX-License-Identifier: BSD-2-Clause
// Where the text of a description of the cluster is to be had.
#pragma once
#include <memory>
#include <string>
#include <utility>

#include "base/sha256.hpp"
#include "daemon/outside/description_texts.hpp"

namespace mlcca {

/// Of one digest: what is kept here, or in its place what is in the store. On any thread.
struct TextSource {
  Sha256::Digest digest{};
  DescriptionTexts::Reader kept;
  std::shared_ptr<const std::string> stored;

  [[nodiscard]] std::shared_ptr<const std::string> text(std::string& damage) const {
    if (digest == Sha256::Digest{}) return nullptr;
    KeptText known = kept(digest);
    damage = std::move(known.damage);
    return known.text ? std::make_shared<const std::string>(std::move(*known.text)) : stored;
  }
};

}  // namespace mlcca
