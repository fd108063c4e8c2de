// SPDX-License-Identifier: BSD-2-Clause
// Resolves the href of an inclusion: a URI reference (RFC 3986), of which only a path is allowed.
#include "description/include.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <optional>

#include "base/number.hpp"
#include "description/problems.hpp"

namespace mlcca::description {
namespace {

constexpr std::string_view kRightHref =
    "is not right: it must be the path of a local file, relative to this one or absolute";

/// Whether the text begins with a scheme (RFC 3986, 3.1): letter (letter | digit | + | - | .)* ":".
bool has_scheme(std::string_view href) {
  const auto colon = href.find(':');
  return colon != std::string_view::npos && href.find('/') > colon;
}

/// The percent-decoded text; nullopt if a % is not followed by two hexadecimal digits, or encodes
/// NUL.
std::optional<std::string> decoded(std::string_view text) {
  std::string out;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] != '%') {
      out += text[i];
      continue;
    }
    const auto digits = text.substr(i + 1, 2);
    const auto value = number_in<std::uint8_t>(digits, kHexadecimalBase);
    if (digits.size() < 2 || value.value_or(0) == 0) return std::nullopt;
    out += static_cast<char>(*value);
    i += 2;
  }
  return out;
}

std::unexpected<std::string> wrong(std::string_view href, std::string_view why) {
  return std::unexpected(fmt::format("attribute href: '{}' {}", clipped(href, 80), why));
}

}  // namespace

std::string explain_include_key(std::string_view key, std::string_view value) {
  if (key == "parse" && value == "xml") return {};
  if (key == "parse")
    return fmt::format("attribute parse: '{}' is not read, only XML is: remove it",
                       clipped(value, 80));
  if (key == "xpointer") return "attribute xpointer is not read: a file is included as a whole";
  return fmt::format("attribute {} is not known: xi:include has href", key);
}

std::expected<std::string, std::string> included_path(std::string_view href,
                                                      std::string_view folder) {
  if (href.empty()) return std::unexpected("attribute href is empty: it names the file");
  if (href.size() >= kMaxHref) return wrong(href, "is too long for a path");
  if (href.contains('#'))
    return wrong(href, "names a part of a file: only a whole one is included (%23 stands for #)");
  if (href.contains('?'))
    return wrong(href, "has a query: it must be the path of a local file (%3F stands for ?)");
  if (has_scheme(href) || href.starts_with("//")) return wrong(href, kRightHref);
  const auto path = decoded(href);
  if (!path) return wrong(href, "is not right: % is followed by two hexadecimal digits, not 00");
  if (path->starts_with('/')) return *path;
  return std::string(folder) + *path;
}

std::string_view folder_of(std::string_view path) {
  const auto slash = path.rfind('/');
  return slash == std::string_view::npos ? std::string_view() : path.substr(0, slash + 1);
}

}  // namespace mlcca::description
