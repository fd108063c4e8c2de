// SPDX-License-Identifier: BSD-2-Clause
#include "description/names.hpp"

#include <fmt/format.h>

#include <string>

#include "description/suggest.hpp"

namespace mlcca::description {
namespace {

/// Problems up to which names are suggested. Comparing names is the slowest operation here, so a
/// hostile file must not cause more of it.
constexpr std::size_t kMostSuggestions = 50;

}  // namespace

void Index::reserve(std::size_t names) {
  index_.reserve(names);
  names_.reserve(names);
}

void Index::add(std::string_view name) {
  index_.try_emplace(name, names_.size());
  names_.push_back(name);
}

std::optional<std::size_t> Index::find(std::string_view name) const {
  // If a name occurs twice, the first one counts, so the hint must not find the second.
  if (next_ < names_.size() && names_[next_] == name && index_.size() == names_.size())
    return next_++;
  const auto found = index_.find(name);
  if (found == index_.end()) return std::nullopt;
  next_ = found->second + 1;
  return found->second;
}

std::optional<std::size_t> Index::find(std::string_view name, core::Origin origin,
                                       std::string_view element, Problems& problems) const {
  if (const auto found = find(name)) return found;
  std::string text = fmt::format("{} {} is not described", kind_, name);
  if (problems.size() < kMostSuggestions) text += "; " + known_names(name, names_);
  problems.add(origin, element, text, core::FindingId::unknown_name);
  return std::nullopt;
}

std::string line_words(const std::vector<std::string>& files, core::Origin here,
                       core::Origin there) {
  if (here.file == there.file) return fmt::format("line {}", there.line);
  return fmt::format("line {} of {}", there.line, files[there.file]);
}

std::string line_words(const core::System& system, core::Origin here, core::Origin there) {
  return line_words(system.files, here, there);
}

}  // namespace mlcca::description
