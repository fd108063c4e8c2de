// SPDX-License-Identifier: BSD-2-Clause
// The compiled-in schema and the translation of the validator's messages.
#include "description/schema.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <vector>

#include "description/problems.hpp"
#include "description/read.hpp"
#include "description/suggest.hpp"

namespace mlcca::description {
namespace {

constexpr char kSchema[] =
#include "system_xsd.inc"
    ;

constexpr auto kTypeWords = std::to_array<TypeWords>({
    {"Name", R"([A-Za-z][A-Za-z0-9._\-]{0,62})",
     "a letter, then up to 62 letters, digits, dots, underscores or hyphens"},
    {"HostName", R"([A-Za-z0-9][A-Za-z0-9.\-]{0,63})",
     "up to 64 letters, digits, dots or hyphens, starting with a letter or digit"},
    {"UserName", R"([A-Za-z0-9_][A-Za-z0-9_.@\-]{0,63})", "a user's name or number"},
    {"InterfaceName", R"([A-Za-z0-9_][A-Za-z0-9_.@+\-]{0,14})",
     "up to 15 letters, digits or _ . @ + -, as the kernel names interfaces"},
    {"Subject", "0x[0-9a-fA-F]{1,16}", "0x and up to 16 hexadecimal digits"},
    {"ShortHex", "0x[0-9a-fA-F]{1,8}", "0x and up to 8 hexadecimal digits"},
    {"SmallNumber", "0x[0-9a-fA-F]{1,2}|[0-9]{1,3}", "a number such as 32 or 0x20, without a sign"},
    {"Decimal", R"([0-9]{1,20}(\.[0-9]{1,20})?)",
     "a decimal number such as 50 or 0.5, without a sign, up to 20 digits on each side"},
    {"DeviceText", "", "1 to 255 characters"},
    {"Text", "", "up to 1024 characters"},
    {"Exponent", "", "a whole number from -9 to 9"},
    {"Magnitude", "", "a whole number from -30 to 30"},
    {"PortNumber", "", "a whole number from 0 to 65535"},
    {"Bitrate", "", "a whole number of bits per second from 1 to 1000000"},
    {"DataBitrate", "", "a whole number of bits per second from 1 to 8000000"},
    {"xs:boolean", "", "true or false"},
});

template <class... T>
constexpr std::array<std::string_view, sizeof...(T)> names(T... n) {
  return {std::string_view(n)...};
}

constexpr std::array<std::string_view, 0> kNone{};
constexpr auto kName = names("name");
constexpr auto kDynamic = names("dynamic");
constexpr auto kAttribute = names("Attribute");
constexpr auto kAttributes = names("Attributes");
constexpr auto kSystem = names("EventChannel", "Network", "Gateway", "Publisher", "Subscriber");
constexpr auto kChannel = names("SubjectUID", "Description", "Attributes");
constexpr auto kQuantity = names("Name", "Dimension", "Value");
constexpr auto kDimension = names("SIUnit", "Magnitude");
constexpr auto kUnit = names("Seconds", "Bytes");
constexpr auto kNetwork = names("Kind", "Profile", "Provision", "Binding");
constexpr auto kBinding = names("ETag", "Identifier");
constexpr auto kBindingKeys = names("channel", "format", "remote-frames");
constexpr auto kForm = names("form");
constexpr auto kGateway = names("Provision", "Port");
constexpr auto kGatewayKeys = names("name", "host");
constexpr auto kPort = names("Interface", "Bitrate", "DataBitrate");
constexpr auto kPortKeys = names("network", "managed");
constexpr auto kInterfaceKeys = names("name", "id-path", "serial", "alias", "port");
constexpr auto kPublisherKeys =
    names("channel", "network", "gateway", "name", "node", "priority", "user");
constexpr auto kSubscriberKeys = names("channel", "network", "gateway", "name");

constexpr auto kElementWords = std::to_array<ElementWords>({
    {"System", kSystem, kName},
    {"EventChannel", kChannel, kName},
    {"Attributes", kAttribute, kNone},
    {"Provision", kAttribute, kNone},
    {"Attribute", kQuantity, kDynamic},
    {"Dimension", kDimension, kNone},
    {"SIUnit", kUnit, kNone},
    {"Network", kNetwork, kName},
    {"Binding", kBinding, kBindingKeys},
    {"Identifier", kNone, kForm},
    {"Gateway", kGateway, kGatewayKeys},
    {"Port", kPort, kPortKeys},
    {"Interface", kNone, kInterfaceKeys},
    {"Publisher", kAttributes, kPublisherKeys},
    {"Subscriber", kAttributes, kSubscriberKeys},
});

constexpr std::size_t kShownValue = 80;  // bytes of a value that is quoted

/// The texts in single quotes.
std::vector<std::string_view> quoted(std::string_view text) {
  std::vector<std::string_view> out;
  for (;;) {
    const auto open = text.find('\'');
    if (open == std::string_view::npos) return out;
    const auto close = text.find('\'', open + 1);
    if (close == std::string_view::npos) return out;
    out.push_back(text.substr(open + 1, close - open - 1));
    text.remove_prefix(close + 1);
  }
}

/// What stands between two marks, or nothing.
std::string_view between(std::string_view text, std::string_view before, std::string_view after) {
  const auto from = text.find(before);
  if (from == std::string_view::npos) return {};
  text.remove_prefix(from + before.size());
  const auto to = text.rfind(after);
  return to == std::string_view::npos ? std::string_view{} : text.substr(0, to);
}

std::string did_you_mean(std::string_view name, std::span<const std::string_view> known) {
  const auto close = closest(name, known);
  return close.empty() ? "" : fmt::format("; did you mean {}?", close);
}

std::string_view words_for_type(std::string_view type) {
  const auto* row = std::ranges::find(kTypeWords, type, &TypeWords::type);
  return row == kTypeWords.end() ? type : row->words;
}

std::string_view words_for_pattern(std::string_view pattern) {
  const auto* row = std::ranges::find(kTypeWords, pattern, &TypeWords::pattern);
  return row == kTypeWords.end() ? pattern : row->words;
}

/// The value that a message is about, no longer than a person reads it.
std::string value_in(std::string_view message, std::string_view before, std::string_view after) {
  return clipped(between(message, before, after), kShownValue);
}

std::string explain_enumeration(std::string_view message) {
  const auto value = value_in(message, "The value '", "' is not an element of the set");
  const auto known = quoted(between(message, " of the set {", "}"));
  return fmt::format("'{}' is not one of {}{}", value, fmt::join(known, ", "),
                     did_you_mean(value, known));
}

std::string explain_unexpected(std::string_view element, std::string_view parent,
                               std::string_view message) {
  const auto* row = words_of(parent);
  if (row == nullptr) return fmt::format("is not expected: {} is a plain value", parent);
  if (row->children.empty()) return fmt::format("is not expected: {} is empty", parent);
  const auto order =
      fmt::format("{} has {}, in this order", parent, fmt::join(row->children, ", "));
  if (std::ranges::find(row->children, element) == row->children.end())
    return fmt::format("is not known here: {}{}", order, did_you_mean(element, row->children));
  const auto expected = between(message, "Expected is ", ".");
  return expected.empty() ? fmt::format("is one too many or out of place: {}", order)
                          : fmt::format("is not expected here, but {}: {}", expected, order);
}

std::string explain_attribute(std::string_view name, std::string_view element,
                              std::string_view parent) {
  const auto* row = words_of(element);
  if (element == "Attribute" && name == "dynamic" && parent != "Provision")
    return "attribute dynamic is only for a Provision: a requirement is never a best case";
  if (row == nullptr || row->attributes.empty())
    return fmt::format("attribute {} is not known: {} has none", name, element);
  return fmt::format("attribute {} is not known: {} has {}{}", name, element,
                     fmt::join(row->attributes, ", "), did_you_mean(name, row->attributes));
}

/// About the value of an element or attribute.
std::string explain_value(std::string_view message) {
  // A whole message ends in a full stop; the library cuts one with a value of some 64000 bytes.
  if (!message.ends_with('.')) return "is far too long";
  if (message.contains("[facet 'enumeration']")) return explain_enumeration(message);
  if (message.contains("[facet 'pattern']"))
    return fmt::format("'{}' is not right: it must be {}",
                       value_in(message, "The value '", "' is not accepted by the pattern"),
                       words_for_pattern(between(message, "by the pattern '", "'")));
  if (message.contains("' is not a valid value of the "))
    return fmt::format(
        "'{}' is not right: it must be {}",
        value_in(message, "'", "' is not a valid value of the "),
        words_for_type(between(message.substr(message.find("is not a valid")), "type '", "'")));
  if (const auto most = between(message, "the allowed maximum length of '", "'"); !most.empty())
    return fmt::format("is longer than {} characters", most);
  if (const auto least = between(message, "the allowed minimum length of '", "'"); !least.empty())
    return fmt::format("is shorter than {} character", least);
  if (const auto most = between(message, "than the maximum value allowed ('", "'"); !most.empty())
    return fmt::format("{} is too large: at most {}",
                       value_in(message, "The value '", "' is greater"), most);
  if (const auto least = between(message, "than the minimum value allowed ('", "'"); !least.empty())
    return fmt::format("{} is too small: at least {}",
                       value_in(message, "The value '", "' is less"), least);
  return std::string(message);
}

}  // namespace

std::string_view schema() { return {kSchema, sizeof(kSchema) - 1}; }

std::span<const TypeWords> type_words() { return kTypeWords; }
std::span<const ElementWords> element_words() { return kElementWords; }

const ElementWords* words_of(std::string_view element) {
  const auto* row = std::ranges::find(kElementWords, element, &ElementWords::element);
  return row == kElementWords.end() ? nullptr : row;
}

std::string explain_schema_message(std::string_view message, std::string_view element,
                                   std::string_view parent) {
  while (message.ends_with('\n')) message.remove_suffix(1);
  if (message.starts_with("Element '"))
    message.remove_prefix(std::min(message.find("': "), message.find("', ")) + 1);
  std::string_view attribute;
  if (message.starts_with(", attribute '")) {
    message.remove_prefix(13);
    attribute = message.substr(0, message.find('\''));
    message.remove_prefix(std::min(attribute.size() + 1, message.size()));
  }
  if (message.starts_with(": ")) message.remove_prefix(2);

  if (message.starts_with("This element is not expected."))
    return explain_unexpected(element, parent, message);
  if (const auto missing = between(message, "Missing child element(s). Expected is ", ".");
      !missing.empty())
    return fmt::format("is not complete: it needs {}", missing);
  if (message.starts_with("Character content"))
    return "holds text, which has no meaning here: its content goes into elements";
  if (message.starts_with("Element content is not allowed"))
    return fmt::format("is not expected: {} is a plain value", parent);
  if (const auto key = between(message, "The attribute '", "' is required but missing");
      !key.empty())
    return fmt::format("attribute {} is missing", key);
  if (message.ends_with("is not allowed.") && !attribute.empty())
    return explain_attribute(attribute, element, parent);
  const auto value = explain_value(message);
  return attribute.empty() ? value : fmt::format("attribute {}: {}", attribute, value);
}

}  // namespace mlcca::description
