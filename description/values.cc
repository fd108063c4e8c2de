// SPDX-License-Identifier: BSD-2-Clause
// The table of simple types and their checks.
#include "description/values.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <limits>
#include <optional>
#include <span>

#include "core/model/words.hpp"
#include "description/problems.hpp"
#include "description/suggest.hpp"

namespace mlcca::description {

namespace words = core::words;

namespace {

constexpr std::size_t kShownValue = 80;  // bytes of a value that is quoted

/// A set of bytes; what is beyond ASCII is in none.
class Characters {
 public:
  /// Letters, digits and those of `others`.
  static constexpr Characters letters_digits_and(std::string_view others) {
    auto out = letters();
    out.add('0', '9');
    return out.with(others);
  }
  static constexpr Characters letters() {
    Characters out;
    out.add('A', 'Z');
    out.add('a', 'z');
    return out;
  }
  static constexpr Characters digits() {
    Characters out;
    out.add('0', '9');
    return out;
  }
  static constexpr Characters hexadecimal_digits() {
    auto out = digits();
    out.add('A', 'F');
    out.add('a', 'f');
    return out;
  }
  [[nodiscard]] constexpr Characters with(std::string_view others) const {
    auto out = *this;
    for (const char c : others) out.add(c, c);
    return out;
  }
  [[nodiscard]] constexpr bool has(char c) const { return in_[static_cast<unsigned char>(c)]; }

 private:
  constexpr void add(char first, char last) {
    for (char c = first; c <= last; ++c) in_[static_cast<unsigned char>(c)] = true;
  }
  std::array<bool, 256> in_{};
};

constexpr auto kLetters = Characters::letters();
constexpr auto kLettersDigits = Characters::letters_digits_and("");
constexpr auto kNameRest = Characters::letters_digits_and("._-");
constexpr auto kHostRest = Characters::letters_digits_and(".-");
constexpr auto kUserFirst = Characters::letters_digits_and("_");
constexpr auto kUserRest = Characters::letters_digits_and("_.@-");
constexpr auto kInterfaceRest = Characters::letters_digits_and("_.@+-");
constexpr auto kDigits = Characters::digits();
constexpr auto kHexadecimal = Characters::hexadecimal_digits();
constexpr auto kAddress = kHexadecimal.with(".:");

bool all_in(const Characters& set, std::string_view text) {
  return std::ranges::all_of(text, [&](char c) { return set.has(c); });
}

/// One of `first`, then up to `more` of `rest`.
bool is_word(std::string_view text, const Characters& first, const Characters& rest,
             std::size_t more) {
  return !text.empty() && text.size() <= more + 1 && first.has(text.front()) &&
         all_in(rest, text.substr(1));
}

/// 1 to `most` of `set`.
bool is_run(std::string_view text, const Characters& set, std::size_t most) {
  return !text.empty() && text.size() <= most && all_in(set, text);
}

bool is_hexadecimal(std::string_view text, std::size_t most) {
  return text.starts_with("0x") && is_run(text.substr(2), kHexadecimal, most);
}

bool is_name(std::string_view text) { return is_word(text, kLetters, kNameRest, 62); }
bool is_attribute_name(std::string_view text) {
  return is_word(text, kLetters, kLettersDigits, 62);
}
bool is_host_name(std::string_view text) { return is_word(text, kLettersDigits, kHostRest, 63); }
bool is_user_name(std::string_view text) { return is_word(text, kUserFirst, kUserRest, 63); }
bool is_interface_name(std::string_view text) {
  return is_word(text, kUserFirst, kInterfaceRest, 14);
}
bool is_subject(std::string_view text) { return is_hexadecimal(text, 16); }
bool is_channel_name(std::string_view text) { return is_name(text) || is_subject(text); }
bool is_short_hex(std::string_view text) { return is_hexadecimal(text, 8); }
bool is_small_number(std::string_view text) {
  return is_hexadecimal(text, 2) || is_run(text, kDigits, 3);
}
bool is_number(std::string_view text) {
  return is_hexadecimal(text, 5) || is_run(text, kDigits, 6);
}
/// Words of small letters and hyphens, one blank between them.
bool is_word_list(std::string_view text) {
  if (text.empty() || text.front() == ' ' || text.back() == ' ') return false;
  return text.find("  ") == std::string_view::npos &&
         text.find_first_not_of("abcdefghijklmnopqrstuvwxyz0123456789- ") == std::string_view::npos;
}
bool is_decimal(std::string_view text) {
  const auto point = text.find('.');
  if (point == std::string_view::npos) return is_run(text, kDigits, 20);
  return is_run(text.substr(0, point), kDigits, 20) && is_run(text.substr(point + 1), kDigits, 20);
}
bool is_node_address(std::string_view text) {
  return text.size() >= 2 && is_run(text, kAddress, 45);
}
bool is_sender_address(std::string_view text) {
  const bool mac = text.find(':') != std::string_view::npos;
  const char between = mac ? ':' : '.';
  int parts = 0;
  for (;; ++parts) {
    const auto end = std::min(text.find(between), text.size());
    if (!is_run(text.substr(0, end), mac ? kHexadecimal : kDigits, mac ? 2 : 3) ||
        (mac && end != 2))
      return false;
    if (end == text.size()) break;
    text.remove_prefix(end + 1);
  }
  return parts == (mac ? 5 : 3);
}
bool is_subject_range(std::string_view text) {
  if (text == "no" || text == "any") return true;
  const auto slash = text.find('/');
  if (!text.starts_with("0x") || slash == std::string_view::npos) return false;
  const auto bits = text.substr(slash + 1);
  if (!is_run(text.substr(2, slash - 2), kHexadecimal, 16) || !is_run(bits, kDigits, 2) ||
      bits.front() == '0')
    return false;
  return bits.size() == 1 || bits <= "64";
}
bool is_boolean(std::string_view text) {
  return text == "true" || text == "false" || text == "1" || text == "0";
}

constexpr auto kCompositionWords =
    std::to_array<std::string_view>({"sum", "maximum", "minimum", "survival"});
constexpr auto kIdentifierFormWords = std::to_array<std::string_view>({"standard", "extended"});

constexpr ValueType shaped(std::string_view name, std::string_view words, std::string_view pattern,
                           bool (*fits)(std::string_view)) {
  return {.name = name, .words = words, .pattern = pattern, .fits = fits, .values = {}};
}

constexpr ValueType one_of(std::string_view name, std::span<const std::string_view> values) {
  return {.name = name, .words = {}, .pattern = {}, .values = values};
}

constexpr ValueType whole(std::string_view name, long least, long most, std::string_view words) {
  return {.name = name,
          .words = words,
          .pattern = {},
          .values = {},
          .integer = true,
          .least = least,
          .most = most};
}

constexpr ValueType text(std::string_view name, std::size_t shortest, std::size_t longest,
                         std::string_view words) {
  return {.name = name,
          .words = words,
          .pattern = {},
          .values = {},
          .shortest = shortest,
          .longest = longest};
}

/// An optional sign and digits, as a number; nothing for anything else. What is beyond the range of
/// long becomes its end.
std::optional<long> to_integer(std::string_view text) {
  const bool negative = text.starts_with('-');
  if (negative || text.starts_with('+')) text.remove_prefix(1);
  if (text.empty() || !all_in(kDigits, text)) return std::nullopt;
  long value = 0;
  const auto [end, error] = std::from_chars(text.begin(), text.end(), value);
  if (error != std::errc{}) value = std::numeric_limits<long>::max();
  return negative ? -value : value;
}

std::size_t characters(std::string_view utf8) {
  return static_cast<std::size_t>(std::ranges::count_if(
      utf8, [](char c) { return (static_cast<unsigned char>(c) & 0xc0U) != 0x80U; }));
}

std::string explain_enumeration(const ValueType& type, std::string_view shown) {
  const auto close = closest(shown, type.values);
  return fmt::format("'{}' is not one of {}{}", shown, fmt::join(type.values, ", "),
                     close.empty() ? "" : fmt::format("; did you mean {}?", close));
}

}  // namespace

namespace type {

constexpr ValueType kName =
    shaped("Name", "a letter, then up to 62 letters, digits, dots, underscores or hyphens",
           R"([A-Za-z][A-Za-z0-9._\-]{0,62})", is_name);
constexpr ValueType kChannelName =
    shaped("ChannelName",
           "a channel's name (a letter, then up to 62 letters, digits, dots, underscores or "
           "hyphens) or subject (0x and up to 16 hexadecimal digits)",
           R"([A-Za-z][A-Za-z0-9._\-]{0,62}|0x[0-9a-fA-F]{1,16})", is_channel_name);
constexpr ValueType kHostName =
    shaped("HostName", "up to 64 letters, digits, dots or hyphens, starting with a letter or digit",
           R"([A-Za-z0-9][A-Za-z0-9.\-]{0,63})", is_host_name);
constexpr ValueType kUserName = shaped("UserName", "a user's name or number",
                                       R"([A-Za-z0-9_][A-Za-z0-9_.@\-]{0,63})", is_user_name);
constexpr ValueType kInterfaceName =
    shaped("InterfaceName", "up to 15 letters, digits or _ . @ + -, as the kernel names interfaces",
           R"([A-Za-z0-9_][A-Za-z0-9_.@+\-]{0,14})", is_interface_name);
constexpr ValueType kDeviceText = text("DeviceText", 1, 255, "1 to 255 characters");
constexpr ValueType kText = text("Text", 0, 1024, "up to 1024 characters");
constexpr ValueType kSubject =
    shaped("Subject", "0x and up to 16 hexadecimal digits", "0x[0-9a-fA-F]{1,16}", is_subject);
constexpr ValueType kShortHex =
    shaped("ShortHex", "0x and up to 8 hexadecimal digits", "0x[0-9a-fA-F]{1,8}", is_short_hex);
constexpr ValueType kSmallNumber =
    shaped("SmallNumber", "a number such as 32 or 0x20, without a sign",
           "0x[0-9a-fA-F]{1,2}|[0-9]{1,3}", is_small_number);
constexpr ValueType kNumber = shaped("Number", "a number such as 65226 or 0xfeca, without a sign",
                                     "0x[0-9a-fA-F]{1,5}|[0-9]{1,6}", is_number);
constexpr ValueType kMessagePriority =
    whole("MessagePriority", 0, 7, "a whole number from 0 (highest) to 7");
constexpr ValueType kControlKinds =
    shaped("ControlKinds", "all, none, or names of kinds with blanks between them",
           "[a-z0-9\\-]+( [a-z0-9\\-]+)*", is_word_list);
constexpr ValueType kControlRate =
    whole("ControlRate", 1, 10000, "a whole number of frames per second from 1 to 10000");
constexpr ValueType kDecimal = shaped(
    "Decimal", "a decimal number such as 50 or 0.5, without a sign, up to 20 digits on each side",
    R"([0-9]{1,20}(\.[0-9]{1,20})?)", is_decimal);
constexpr ValueType kExponent = whole("Exponent", -9, 9, "a whole number from -9 to 9");
constexpr ValueType kMagnitude = whole("Magnitude", -30, 30, "a whole number from -30 to 30");
constexpr ValueType kPortNumber = whole("PortNumber", 0, 65535, "a whole number from 0 to 65535");
constexpr ValueType kBitrate =
    whole("Bitrate", 1, 1000000, "a whole number of bits per second from 1 to 1000000");
constexpr ValueType kDataBitrate =
    whole("DataBitrate", 1, 8000000, "a whole number of bits per second from 1 to 8000000");
constexpr ValueType kAttributeName =
    shaped("AttributeName", "a letter, then up to 62 letters or digits",
           "[A-Za-z][A-Za-z0-9]{0,62}", is_attribute_name);
constexpr ValueType kBetter = one_of("Better", words::kBetters);
constexpr ValueType kComposition = one_of("Composition", kCompositionWords);
constexpr ValueType kSafeSide = one_of("SafeSide", std::span(words::kSafeSides).subspan<1>());
constexpr ValueType kSetPriority =
    whole("SetPriority", -1000, 1000, "a whole number from -1000 to 1000");
constexpr ValueType kNetworkKind = one_of("NetworkKind", words::kNetworkKinds);
constexpr ValueType kProfile = one_of("Profile", words::kProfiles);
constexpr ValueType kFrameFormat = one_of("FrameFormat", words::kFrameFormats);
constexpr ValueType kIdentifierForm = one_of("IdentifierForm", kIdentifierFormWords);
constexpr ValueType kImportance = whole("Importance", 0, 255, "a whole number from 0 to 255");
constexpr ValueType kErrorCount = whole("ErrorCount", 0, 1000, "a whole number from 0 to 1000");
constexpr ValueType kQueueing = one_of("Queueing", words::kQueueings);
constexpr ValueType kExcess = one_of("Excess", words::kExcesses);
constexpr ValueType kRefused = one_of("Refused", words::kRefusals);
constexpr ValueType kForwarder = one_of("Forwarder", words::kForwarders);
constexpr ValueType kFifoDepth = whole("FifoDepth", 1, 64, "a whole number from 1 to 64");
constexpr ValueType kQueueLength = whole("QueueLength", 1, 10000, "a whole number from 1 to 10000");
constexpr ValueType kInterference = one_of("Interference", words::kInterferences);
constexpr ValueType kHopCount = whole("HopCount", 0, 16, "a whole number from 0 to 16");
constexpr ValueType kPacketBytes =
    whole("PacketBytes", 1, 65535, "a whole number of bytes from 1 to 65535");
constexpr ValueType kHeaderBytes =
    whole("HeaderBytes", 0, 65535, "a whole number of bytes from 0 to 65535");
constexpr ValueType kNodeAddress =
    shaped("NodeAddress", "a MAC address such as 02:00:00:00:00:01, or an IPv4 or IPv6 address",
           "[0-9a-fA-F.:]{2,45}", is_node_address);
constexpr ValueType kSenderAddress =
    shaped("SenderAddress", "the IPv4 or MAC address of one station, such as 192.0.2.7",
           "([0-9]{1,3}\\.){3}[0-9]{1,3}|([0-9a-fA-F]{2}:){5}[0-9a-fA-F]{2}", is_sender_address);
constexpr ValueType kSubjectRange = shaped(
    "SubjectRange",
    "no, any, or a subject and how many of its leading bits count, such as 0x5600000000000000/8",
    "no|any|0x[0-9a-fA-F]{1,16}/([1-9]|[1-5][0-9]|6[0-4])", is_subject_range);
constexpr ValueType kUnlistedCount = whole("UnlistedCount", 1, 256, "a whole number from 1 to 256");
constexpr ValueType kLinkRate =
    whole("LinkRate", 1, 1000000000000, "a whole number of bits per second from 1 to 10^12");
constexpr ValueType kMediumNumber =
    whole("MediumNumber", 0, 4294967295, "a whole number from 0 to 4294967295");
constexpr ValueType kRateKind = one_of("RateKind", words::kRateKinds);
constexpr ValueType kSourceKind = one_of("SourceKind", words::kSourceKinds);
constexpr ValueType kLinkMetric = one_of("LinkMetric", words::kAwdsMetrics);
constexpr ValueType kBoolean = shaped("xs:boolean", "true or false", "", is_boolean);

}  // namespace type

namespace {

constexpr auto kTypes = std::to_array<const ValueType*>(
    {&type::kName,           &type::kChannelName,  &type::kHostName,      &type::kUserName,
     &type::kInterfaceName,  &type::kDeviceText,   &type::kText,          &type::kSubject,
     &type::kShortHex,       &type::kSmallNumber,  &type::kNumber,        &type::kMessagePriority,
     &type::kControlKinds,   &type::kControlRate,  &type::kDecimal,       &type::kExponent,
     &type::kMagnitude,      &type::kPortNumber,   &type::kBitrate,       &type::kDataBitrate,
     &type::kAttributeName,  &type::kBetter,       &type::kComposition,   &type::kSafeSide,
     &type::kSetPriority,    &type::kNetworkKind,  &type::kProfile,       &type::kFrameFormat,
     &type::kIdentifierForm, &type::kImportance,   &type::kErrorCount,    &type::kQueueing,
     &type::kExcess,         &type::kFifoDepth,    &type::kQueueLength,   &type::kInterference,
     &type::kHopCount,       &type::kPacketBytes,  &type::kHeaderBytes,   &type::kNodeAddress,
     &type::kSenderAddress,  &type::kSubjectRange, &type::kUnlistedCount, &type::kLinkRate,
     &type::kMediumNumber,   &type::kRateKind,     &type::kSourceKind,    &type::kLinkMetric,
     &type::kForwarder,      &type::kBoolean,      &type::kRefused});

}  // namespace

std::span<const ValueType* const> value_types() { return kTypes; }

bool is_valid(const ValueType& type, std::string_view value) {
  if (type.fits != nullptr) return type.fits(value);
  if (!type.values.empty()) return std::ranges::find(type.values, value) != type.values.end();
  if (type.integer) {
    const auto number = to_integer(value);
    return number && *number >= type.least && *number <= type.most;
  }
  const auto length = characters(value);
  return length >= type.shortest && (type.longest == 0 || length <= type.longest);
}

std::string explain(const ValueType& type, std::string_view value) {
  const auto shown = clipped(value, kShownValue);
  if (!type.values.empty()) return explain_enumeration(type, shown);
  if (type.integer) {
    if (const auto number = to_integer(value)) {
      if (*number > type.most) return fmt::format("{} is too large: at most {}", shown, type.most);
      return fmt::format("{} is too small: at least {}", shown, type.least);
    }
  } else if (type.fits == nullptr) {
    if (characters(value) < type.shortest)
      return fmt::format("is shorter than {} character", type.shortest);
    return fmt::format("is longer than {} characters", type.longest);
  }
  return fmt::format("'{}' is not right: it must be {}", shown, type.words);
}

}  // namespace mlcca::description
