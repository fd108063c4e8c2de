// SPDX-License-Identifier: BSD-2-Clause
// Finds the text of a description of the cluster.
#pragma once
#include <memory>
#include <string>
#include <utility>

#include "base/sha256.hpp"
#include "daemon/outside/description_texts.hpp"

namespace mlcca {

/// The text of one digest: the kept one, or else the one of the store. May be used on any thread.
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
