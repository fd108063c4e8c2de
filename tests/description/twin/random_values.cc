// SPDX-License-Identifier: BSD-2-Clause
#include "tests/description/twin/random_values.hpp"

#include <algorithm>

namespace mlcca::testing {
namespace {

constexpr std::uint64_t kMost = ~std::uint64_t{0} - 1;  // 2^64 - 2
constexpr std::uint64_t kBillion = 1000000000;
constexpr std::size_t kMostDigits = 20;  // on each side of the point

// 2^53 is where floating point begins to skip whole numbers, ten digits are half of a value's.
constexpr std::array<std::uint64_t, 16> kEdges = {0,
                                                  1,
                                                  2,
                                                  5,
                                                  8,
                                                  50,
                                                  999,
                                                  1000,
                                                  kBillion,
                                                  9999999999,
                                                  10000000000,
                                                  (std::uint64_t{1} << 53) - 1,
                                                  std::uint64_t{1} << 53,
                                                  10000000000000000000U,
                                                  kMost - 1,
                                                  kMost};

/// digits * 10^shift as a decimal; nothing where it has too many digits on a side.
std::string decimal(std::string digits, int shift) {
  if (shift >= 0) {
    digits.append(static_cast<std::size_t>(shift), '0');
    return digits.size() <= kMostDigits ? digits : std::string();
  }
  const auto places = static_cast<std::size_t>(-shift);
  if (digits.size() <= places) digits.insert(0, places + 1 - digits.size(), '0');
  std::string fraction = digits.substr(digits.size() - places);
  std::string whole = digits.substr(0, digits.size() - places);
  whole.erase(0, std::min(whole.find_first_not_of('0'), whole.size() - 1));
  fraction.erase(fraction.find_last_not_of('0') + 1);
  if (fraction.size() > kMostDigits || whole.size() > kMostDigits) return {};
  return fraction.empty() ? whole : whole + "." + fraction;
}

/// The same number, written otherwise.
std::string with_needless_zeros(Random& random, std::string text) {
  const auto point = text.find('.');
  const auto before = std::min(point, text.size());
  if (random.one_in(8) && before < kMostDigits) text.insert(0, "0");
  if (random.one_in(8)) {
    if (point == std::string::npos) return text + ".000";
    if (text.size() - text.find('.') <= kMostDigits) text += "0";
  }
  return text;
}

std::string dimension(const std::string& unit, const std::string& magnitude) {
  std::string out;
  if (!unit.empty()) out += "<SIUnit>" + unit + "</SIUnit>";
  if (!magnitude.empty()) out += "<Magnitude>" + magnitude + "</Magnitude>";
  return out.empty() ? out : "<Dimension>" + out + "</Dimension>";
}

std::string magnitude_text(Random& random, int magnitude) {
  if (magnitude == 0 && random.one_in(2)) return {};
  if (magnitude >= 0 && random.one_in(4)) return "+" + std::to_string(magnitude);
  return std::to_string(magnitude);
}

}  // namespace

std::vector<Quantity> built_in_quantities(std::uint64_t most_payload) {
  const std::string seconds = "<Seconds>1</Seconds>";
  const std::string rate = "<Bytes>1</Bytes><Seconds>-1</Seconds>";
  return {{"Latency", seconds, 9, 0, kMost},
          {"Jitter", seconds, 9, 0, kMost},
          {"Deadline", seconds, 9, 1, kMost, false, false},
          {"Period", seconds, 9, 1, kMost},
          {"Bandwidth", rate, 0, 0, kMost, true},
          {"PacketLoss", "", 9, 0, kBillion, false, true, true},
          {"Omission", "", 0, 0, kMost},
          {"MaxPayload", "<Bytes>1</Bytes>", 0, 0, most_payload, true}};
}

Quantity user_quantity(Random& random, const std::string& name) {
  static const std::array<std::string, 4> compositions = {"sum", "maximum", "minimum", "survival"};
  const auto& composition = random.one_of(compositions);
  Quantity out{name, random.one_in(2) ? "<Kelvins>1</Kelvins><Metres>-2</Metres>" : "", 0, 0,
               kMost};
  out.scale = static_cast<int>(random.below(12)) - 4;
  if (composition == "survival") {
    out.unit.clear();
    out.scale = 9;
    out.most = kBillion;
    out.survival = true;
  }
  out.larger = composition == "minimum";
  out.definition = "<UserAttribute name=\"" + name + "\">" +
                   dimension(out.unit, magnitude_text(random, -out.scale)) + "<Better>" +
                   (out.larger ? "larger" : "smaller") + "</Better><Composition>" + composition +
                   "</Composition></UserAttribute>";
  return out;
}

Numbers::Numbers(Random& random) {
  for (auto& number : favourites_)
    number = random.one_in(2) ? random.one_of(kEdges) : random.any() >> random.below(64);
}

std::string Numbers::attribute(Random& random, const Quantity& quantity) {
  std::uint64_t number = random.one_in(3) ? random.any() >> random.below(64)
                                          : random.one_of(favourites_) + random.below(3) - 1;
  if (random.one_in(6)) number = random.one_of(kEdges);
  number = std::clamp(number, quantity.least, quantity.most);
  // A fraction is rounded up or down: one more must be a valid number, too.
  const bool fraction = number < quantity.most && random.one_in(3);
  return written(random, quantity, number, fraction ? std::to_string(random.below(99999)) : "");
}

std::string Numbers::attribute(Random& random, const Quantity& quantity, bool best) {
  return written(random, quantity, quantity.larger == best ? quantity.most : quantity.least, "");
}

std::string Numbers::written(Random& random, const Quantity& quantity, std::uint64_t number,
                             const std::string& fraction) {
  const std::string digits = std::to_string(number) + fraction;
  const int point = -static_cast<int>(fraction.size()) - quantity.scale;
  std::string text;
  int magnitude = 0;
  while (text.empty()) {
    magnitude = random.one_in(3) ? static_cast<int>(random.below(61)) - 30
                                 : static_cast<int>(random.below(7)) - quantity.scale;
    magnitude = std::clamp(magnitude, -30, 30);
    text = decimal(digits, point - magnitude);
  }
  text = with_needless_zeros(random, text);
  if (random.one_in(10)) text = "\n " + text + " ";
  return "<Name>" + (random.one_in(10) ? " " + quantity.name + "\n" : quantity.name) + "</Name>" +
         dimension(quantity.unit, magnitude_text(random, magnitude)) + "<Value>" + text +
         "</Value>";
}

}  // namespace mlcca::testing
