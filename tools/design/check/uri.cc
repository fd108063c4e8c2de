// SPDX-License-Identifier: BSD-2-Clause
#include "tools/design/check/uri.hpp"

#include <fmt/format.h>

#include <filesystem>
#include <system_error>

namespace mlcca::tools::design {
namespace {

/// Encodes all but the unreserved characters (RFC 3986, 2.3) and the slash.
std::string percent_encoded(std::string_view path) {
  constexpr std::string_view plain_ones =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789-._~/";
  std::string out;
  for (const char c : path) {
    if (plain_ones.contains(c))
      out += c;
    else
      out += fmt::format("%{:02X}", static_cast<unsigned char>(c));
  }
  return out;
}

}  // namespace

FileUri file_uri(std::string_view path, std::string_view folder) {
  const auto plain = std::filesystem::path(path).lexically_normal();
  const bool relative = plain.is_relative() && *plain.begin() != "..";
  if (relative) return {percent_encoded(plain.native()), true};
  const auto whole = (std::filesystem::path(folder) / plain).lexically_normal();
  return {"file://" + percent_encoded(whole.native()), false};
}

FileUri file_uri(std::string_view path) {
  std::error_code gone;
  return file_uri(path, std::filesystem::current_path(gone).native());
}

}  // namespace mlcca::tools::design
