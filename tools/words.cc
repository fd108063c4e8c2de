// SPDX-License-Identifier: BSD-2-Clause
#include "tools/words.hpp"

#include <fmt/format.h>

#include <array>

#include "control/event_kinds.hpp"
#include "mlcca/arithmetic.hpp"
#include "tools/values.hpp"

namespace mlcca::tools {
namespace {

constexpr std::uint64_t kBitsPerByte = 8;
/// thousandths of a percent in 100 %
constexpr std::uint64_t kThousandths = 100'000;

struct BitRateUnit {
  const char* name;
  std::uint64_t size;
};
constexpr std::array kBitRates = {BitRateUnit{"Gbit/s", 1'000'000'000},
                                  BitRateUnit{"Mbit/s", 1'000'000}, BitRateUnit{"kbit/s", 1'000}};

/// `count` / `unit` rounded to thousandths; `unit` is 1 or a multiple of 1000.
std::string decimal(std::uint64_t count, std::uint64_t unit) {
  const std::uint64_t step = unit < 1'000 ? 1 : unit / 1'000;
  const std::uint64_t steps = count / step + (count % step >= (step + 1) / 2 && step > 1 ? 1 : 0);
  const std::uint64_t whole = steps / (unit / step);
  auto text = fmt::format("{}", whole);
  if (const auto rest = steps % (unit / step); rest != 0) {
    text += fmt::format(".{:03}", rest);
    text.erase(text.find_last_not_of('0') + 1);
  }
  return text;
}

}  // namespace

Cell verdict_cell(bool granted) {
  return granted ? Cell{"granted", Style::good} : Cell{"refused", Style::bad};
}

Style style_of_event(std::string_view kind) {
  const auto* const known = control::event_kind(kind);
  switch (known != nullptr ? known->tone : control::Tone::plain) {
    case control::Tone::good:
      return Style::good;
    case control::Tone::bad:
      return Style::bad;
    case control::Tone::warning:
      return Style::warning;
    case control::Tone::plain:
      break;
  }
  return Style::plain;
}

std::string print_sender(const control::Unknown& frame) {
  if (frame.address.empty() || frame.mac.empty()) return frame.address + frame.mac;
  return fmt::format("{} ({})", frame.address, frame.mac);
}

std::string bytes_per_second(std::uint64_t rate) {
  return print_value("Bandwidth", rate, "bytes/s");
}

std::string bits_per_second(std::uint64_t rate) {
  if (rate == kUnbounded) return "unbounded";
  for (const auto& unit : kBitRates)
    if (rate >= unit.size) return decimal(rate, unit.size) + " " + unit.name;
  return fmt::format("{} bit/s", rate);
}

std::string percent(std::uint64_t parts, std::uint64_t whole) {
  const auto thousandths = mul_div_down(parts, 2 * kThousandths, whole);
  if (parts == kUnbounded || thousandths == kUnbounded) return "unbounded";
  if (parts != 0 && thousandths == 0) return "< 0.001 %";
  return decimal(thousandths / 2 + thousandths % 2, 1'000) + " %";
}

std::string path_rate(const control::MediumUse& use) {
  return bits_per_second(mul_saturating(use.path_rate, kBitsPerByte));
}

std::string way(const std::vector<std::string>& places) {
  return fmt::format("{}", fmt::join(places, " > "));
}

std::string describe(const control::MediumUse& use) {
  std::vector<std::string> parts;
  if (use.response_ns != 0) {
    parts.push_back("response " + print_duration(use.response_ns));
    if (use.guaranteed_ns != 0)
      parts.push_back(fmt::format("at most {} guaranteed", print_duration(use.guaranteed_ns)));
  }
  if (!use.path.empty()) parts.push_back("path " + way(use.path));
  if (use.path_rate != 0) {
    parts.push_back("path rate " + path_rate(use));
    parts.push_back(bytes_per_second(use.available) + " free or its own");
    if (!use.limited_by.empty()) parts.back() += ", in " + use.limited_by;
  }
  return fmt::format("{}", fmt::join(parts, ", "));
}

std::string set_in_use(const control::Channel& channel) {
  if (channel.sets <= 1) return {};
  return channel.granted ? fmt::format("{} of {}", channel.set + 1, channel.sets)
                         : fmt::format("none of {}", channel.sets);
}

}  // namespace mlcca::tools
