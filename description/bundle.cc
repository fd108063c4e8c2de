// SPDX-License-Identifier: BSD-2-Clause
#include "description/bundle.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cstdint>
#include <optional>
#include <utility>

#include "base/number.hpp"
#include "base/text.hpp"
#include "description/xml.hpp"

namespace mlcca::description {
namespace {

constexpr std::string_view kBundleHead = "MLCCA description 1\n";
constexpr std::size_t kMaxName = 4096;

bool is_plain(std::string_view name) {
  return name.size() <= kMaxName && std::ranges::none_of(name, [](unsigned char c) {
           return c < ' ' || c == 127;  // NOLINT(*-magic-numbers)
         });
}

/// Returns the text up to `end` and removes both from `text`; nullopt if `end` is missing.
std::optional<std::string_view> up_to(std::string_view& text, char end) {
  const auto at = text.find(end);
  if (at == std::string_view::npos) return std::nullopt;
  const auto out = text.substr(0, at);
  text.remove_prefix(at + 1);
  return out;
}

std::optional<FileInBundle> next_file(std::string_view& text) {
  const auto size = up_to(text, ' ');
  const auto bytes = size ? number_in<std::uint64_t>(*size) : std::nullopt;
  const auto name = bytes ? up_to(text, '\n') : std::nullopt;
  if (!name || !is_plain(*name) || *bytes > text.size()) return std::nullopt;
  const FileInBundle out{.name = *name, .content = text.substr(0, *bytes)};
  text.remove_prefix(*bytes);
  return out;
}

}  // namespace

std::string bundle_of(const std::vector<BundledFile>& files) {
  std::string out(kBundleHead);
  for (const BundledFile& file : files) {
    out += fmt::format("{} {}\n", file.content.size(), printable(file.name, kMaxName));
    out += file.content;
    if (out.size() > kMaxBundle) return {};
  }
  return out;
}

std::expected<std::vector<FileInBundle>, std::string> files_in(std::string_view bundle) {
  if (bundle.size() > kMaxBundle || !bundle.starts_with(kBundleHead))
    return std::unexpected("this is no description as gateways hand it on");
  bundle.remove_prefix(kBundleHead.size());
  std::vector<FileInBundle> files;
  while (!bundle.empty()) {
    const auto file = next_file(bundle);
    if (!file || files.size() >= kMaxFiles)
      return std::unexpected(fmt::format("file {} of it is damaged", files.size() + 1));
    files.push_back(*file);
  }
  if (files.empty()) return std::unexpected("there is no file in it");
  return files;
}

Sha256::Digest digest_of(std::span<const Sha256::Digest> files) {
  Sha256 all;
  for (const Sha256::Digest& one : files)
    for (const std::uint8_t octet : one) {
      const auto c = static_cast<char>(octet);
      all.add({&c, 1});
    }
  return all.digest();
}

std::optional<Sha256::Digest> digest_of(std::string_view bundle) {
  const auto files = files_in(bundle);
  if (!files) return std::nullopt;
  std::vector<Sha256::Digest> digests;
  for (const FileInBundle& file : *files) {
    Sha256 hash;
    hash.add(file.content);
    digests.push_back(hash.digest());
  }
  return digest_of(digests);
}

}  // namespace mlcca::description
