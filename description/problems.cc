// SPDX-License-Identifier: BSD-2-Clause
// Collecting problems: cleaned, cut, without repetitions, ordered by line.
#include "description/problems.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

namespace mlcca::description {
namespace {

std::string printable(std::string_view text) {
  auto out = clipped(text, kMaxProblemText);
  for (auto& c : out)
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) c = ' ';
  return out;
}

}  // namespace

std::string clipped(std::string_view text, std::size_t bytes) {
  if (text.size() <= bytes) return std::string(text);
  std::size_t end = bytes;
  while (end > 0 && (static_cast<unsigned char>(text[end]) & 0xc0U) == 0x80U) --end;
  return std::string(text.substr(0, end)) + "…";
}

std::string to_string(const Problem& problem) {
  std::string out = problem.file;
  if (problem.line > 0) out += fmt::format(":{}", problem.line);
  if (!problem.element.empty()) out += fmt::format(": <{}>", problem.element);
  return out + ": " + problem.text;
}

void Problems::add(int line, std::string_view element, std::string_view text) {
  Problem problem{file_, line, printable(element), printable(text)};
  if (!found_.empty() && found_.back() == problem) return;
  if (found_.size() == kMaxProblems)
    overflowing_ = true;
  else
    found_.push_back(std::move(problem));
}

std::vector<Problem> Problems::take() {
  auto out = std::exchange(found_, {});
  std::ranges::stable_sort(out, {}, &Problem::line);
  if (std::exchange(overflowing_, false))
    out.push_back({file_, 0, "", "there are more problems than these: repair them first"});
  return out;
}

}  // namespace mlcca::description
