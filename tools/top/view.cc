// SPDX-License-Identifier: BSD-2-Clause
#include "tools/top/view.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cctype>

namespace mlcca::tools::top {
namespace {

constexpr std::array<std::string_view, kFields> kNames = {
    "name", "route", "verdict", "rate", "jitter", "loss", "drops", "reserved", "used"};

constexpr char kEscape = '\x1b';
constexpr char kControlU = '\x15';
constexpr char kControlH = '\x08';
constexpr char kDelete = '\x7f';

std::optional<double> value_of(const Row& row, Field field) {
  switch (field) {
    case Field::rate:
      return row.rate;
    case Field::jitter:
      return row.jitter;
    case Field::loss:
      return row.loss;
    case Field::drops:
      return row.drops;
    case Field::reserved:
      return row.reserved;
    case Field::used:
      return row.used;
    case Field::name:
    case Field::place:
    case Field::verdict:
      break;
  }
  return std::nullopt;
}

const std::string& text_of(const Row& row, Field field) {
  if (field == Field::place) return row.place;
  return field == Field::verdict ? row.verdict : row.name;
}

bool is_text(Field field) { return field <= Field::verdict; }

/// Whether `text` contains `part`, regardless of case.
bool contains(std::string_view text, std::string_view part) {
  const auto lower = [](char c) {
    return static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  };
  return !std::ranges::search(text, part, {}, lower, lower).empty() || part.empty();
}

/// The length of the key at the beginning of `keys`; 0 if it is incomplete.
std::size_t length_of_key(std::string_view keys) {
  if (keys[0] != kEscape) return 1;
  if (keys.size() == 1) return 1;  // the key itself: a terminal sends a sequence at once
  if (keys[1] != '[' && keys[1] != 'O') return 1;
  for (std::size_t i = 2; i < keys.size(); ++i)
    if (keys[i] >= '@' && keys[i] <= '~') return i + 1;
  return 0;
}

void type(View& view, std::string_view key) {
  if (key == "\r" || key == "\n") {
    view.filter = view.typed;
    view.typing = false;
    view.first = 0;
  } else if (key[0] == kEscape) {
    view.typing = view.typing && key.size() > 1;
  } else if (key[0] == kDelete || key[0] == kControlH) {
    // Removes a complete character of UTF-8.
    while (!view.typed.empty()) {
      const auto last = static_cast<unsigned char>(view.typed.back());
      view.typed.pop_back();
      if ((last & 0xc0U) != 0x80) break;
    }
  } else if (key[0] == kControlU) {
    view.typed.clear();
  } else if (static_cast<unsigned char>(key[0]) >= ' ') {
    constexpr std::size_t longest = 64;
    if (view.typed.size() < longest) view.typed += key;
  }
}

void move(View& view, std::string_view key, std::size_t page) {
  const auto up = [&](std::size_t by) { view.first -= std::min(view.first, by); };
  if (key == "k" || key == "\x1b[A" || key == "\x1bOA") up(1);
  if (key == "j" || key == "\x1b[B" || key == "\x1bOB") ++view.first;
  if (key == "\x1b[5~") up(page);
  if (key == "\x1b[6~") view.first += page;
  if (key == "\x1b[H" || key == "\x1bOH" || key == "\x1b[1~") view.first = 0;
}

void press(View& view, std::string_view key, std::size_t page) {
  if (view.help && key != "q") {
    view.help = false;
    return;
  }
  switch (key.size() == 1 ? key[0] : '\0') {
    case 'q':
      view.quit = true;
      break;
    case 's':
      view.sort = static_cast<Field>((static_cast<std::size_t>(view.sort) + 1) % kFields);
      break;
    case 'r':
      view.reverse = !view.reverse;
      break;
    case 'n':
      view.by_network = !view.by_network;
      view.first = 0;
      break;
    case ' ':
      view.paused = !view.paused;
      break;
    case '/':
      view.typing = true;
      view.typed = view.filter;
      break;
    case 'h':
    case '?':
      view.help = true;
      break;
    default:
      move(view, key, page);
  }
}

}  // namespace

std::string_view name_of(Field field) { return kNames[static_cast<std::size_t>(field)]; }

std::optional<Field> field_named(std::string_view name) {
  const auto* const found = std::ranges::find(kNames, name);
  if (found == kNames.end()) return std::nullopt;
  return static_cast<Field>(found - kNames.begin());
}

std::string field_names() { return fmt::format("{}", fmt::join(kNames, ", ")); }

View after(View view, std::string& keys, std::size_t page) {
  std::size_t done = 0;
  while (done < keys.size() && !view.quit) {
    const std::string_view rest = std::string_view(keys).substr(done);
    const auto length = length_of_key(rest);
    if (length == 0) break;
    const auto key = rest.substr(0, length);
    if (view.typing)
      type(view, key);
    else
      press(view, key, page);
    done += length;
  }
  keys.erase(0, done);
  return view;
}

std::vector<Row> arranged(std::vector<Row> rows, const View& view) {
  std::erase_if(rows, [&](const Row& row) {
    return !contains(row.name, view.filter) && !contains(row.place, view.filter) &&
           !contains(row.verdict, view.filter) && !contains(row.subject, view.filter);
  });
  std::ranges::stable_sort(rows, [&](const Row& a, const Row& b) {
    if (is_text(view.sort)) {
      const auto& x = text_of(a, view.sort);
      const auto& y = text_of(b, view.sort);
      return view.reverse ? y < x : x < y;
    }
    // Unknown values come last in either order.
    const auto x = value_of(a, view.sort);
    const auto y = value_of(b, view.sort);
    if (!x || !y) return x.has_value() && !y.has_value();
    return view.reverse ? *x < *y : *y < *x;
  });
  return rows;
}

}  // namespace mlcca::tools::top
