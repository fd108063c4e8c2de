// SPDX-License-Identifier: BSD-2-Clause
// Collects problems: cleaned, shortened, without repetitions, ordered by file and line.
#include "description/problems.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <utility>

#include "base/text.hpp"

namespace mlcca::description {
namespace {

std::string in_one_line(std::string_view text) {
  auto out = clipped(text, kMaxProblemText);
  for (auto& c : out)
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) c = ' ';
  return out;
}

}  // namespace

std::string clipped(std::string_view text, std::size_t bytes) {
  if (text.size() <= bytes) return std::string(text);
  return std::string(cut(text, bytes)) + "…";
}

std::string to_string(const Problem& problem) {
  std::string out = problem.file;
  if (problem.line > 0) out += fmt::format(":{}", problem.line);
  if (!problem.element.empty()) out += fmt::format(": <{}>", problem.element);
  return out + ": " + problem.text;
}

std::uint32_t Problems::add_file(const std::string& file) {
  const auto known = std::ranges::find(files_, file);
  const auto number = static_cast<std::uint32_t>(std::distance(files_.begin(), known));
  if (known == files_.end()) files_.push_back(file);
  return number;
}

void Problems::add(core::Origin at, std::string_view element, std::string_view text,
                   core::FindingId id) {
  Entry entry{at, in_one_line(element), in_one_line(text), id};
  const auto same = [&](const Entry& e) {
    return e.at.file == at.file && e.at.line == at.line && e.element == entry.element &&
           e.text == entry.text;
  };
  if (!found_.empty() && same(found_.back())) return;
  if (found_.size() == kMaxProblems)
    overflowing_ = true;
  else
    found_.push_back(std::move(entry));
}

std::vector<Problem> Problems::take() {
  auto found = std::exchange(found_, {});
  std::ranges::stable_sort(found, {},
                           [](const Entry& e) { return std::pair(e.at.file, e.at.line); });
  std::vector<Problem> out;
  out.reserve(found.size() + 1);
  for (auto& e : found)
    out.push_back({name_of(e.at.file), e.at.line, std::move(e.element), std::move(e.text), e.id});
  if (std::exchange(overflowing_, false))
    out.push_back({files_.front(), 0, "", "there are more problems than these: repair them first",
                   core::FindingId::rule});
  return out;
}

}  // namespace mlcca::description
