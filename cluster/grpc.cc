// SPDX-License-Identifier: BSD-2-Clause
#include "cluster/grpc.hpp"

#include <algorithm>
#include <cstdint>
#include <utility>

#include "base/number.hpp"

namespace mlcca::cluster::grpc {
namespace {

constexpr std::size_t kHead = 5;
constexpr std::size_t kMostHeaders = std::size_t{64} << 10U;  // octets of all headers of a call
constexpr std::size_t kMostWords = 300;
constexpr unsigned char kFirstPrintable = 0x20;
constexpr unsigned char kBehindPrintable = 0x7f;

std::size_t length_in(std::string_view head) {
  std::size_t length = 0;
  for (std::size_t i = 1; i < kHead; ++i)
    length = length << 8U | static_cast<unsigned char>(head[i]);
  return length;
}

/// Decodes percent-encoding ("%20" is a space), as grpc-message has it.
std::string decoded(std::string_view text) {
  std::string out;
  while (!text.empty() && out.size() < kMostWords) {
    auto c = static_cast<unsigned char>(text.front());
    text.remove_prefix(1);
    if (c == '%' && text.size() >= 2) {
      if (const auto octet = number_in<std::uint8_t>(text.substr(0, 2), kHexadecimalBase)) {
        c = *octet;
        text.remove_prefix(2);
      }
    }
    const bool printable = c >= kFirstPrintable && c < kBehindPrintable;
    out += printable ? static_cast<char>(c) : '?';
  }
  return out;
}

}  // namespace

std::string framed(std::string_view message) {
  std::string out(1, '\0');
  for (int shift = 24; shift >= 0; shift -= 8)
    out += static_cast<char>(message.size() >> static_cast<unsigned>(shift));
  return out.append(message);
}

bool FrameReader::push(std::string_view octets) {
  if (broken_) return false;
  if (2 * at_ >= octets_.size()) {
    octets_.erase(0, at_);
    checked_ -= std::exchange(at_, 0);
  }
  octets_.append(octets);
  broken_ = !is_right();
  return !broken_;
}

/// Checks the prefixes of all frames that have arrived.
bool FrameReader::is_right() {
  while (octets_.size() >= checked_ + kHead) {
    const std::string_view head = std::string_view(octets_).substr(checked_, kHead);
    too_long_ = length_in(head) > most_;
    if (head[0] != 0 || too_long_) {
      octets_.resize(checked_);
      return false;
    }
    checked_ += kHead + length_in(head);
  }
  return true;
}

std::optional<std::string> FrameReader::next() {
  const std::string_view rest = std::string_view(octets_).substr(at_);
  if (rest.size() < kHead) return std::nullopt;
  const std::size_t length = length_in(rest);
  if (rest.size() - kHead < length) return std::nullopt;
  at_ += kHead + length;
  return std::string(rest.substr(kHead, length));
}

bool Trailers::take(std::string_view line) {
  octets_ += line.size();
  if (octets_ > kMostHeaders) {
    problem_ = "it sends headers without end";
    return false;
  }
  line = line.substr(0, line.find_last_not_of("\r\n ") + 1);
  if (line.starts_with("HTTP/")) {
    if (line.starts_with("HTTP/2 200")) return true;
    problem_ = line.starts_with("HTTP/2 ") ? "it answers " + decoded(line.substr(0, 12))
                                           : "it does not speak HTTP/2";
    return false;
  }
  const auto value_of = [line](std::string_view name) -> std::optional<std::string_view> {
    if (line.size() < name.size()) return std::nullopt;
    const bool is_it = std::ranges::equal(line.substr(0, name.size()), name, [](char a, char b) {
      return a == b || (a >= 'A' && a <= 'Z' && a - 'A' + 'a' == b);
    });
    if (!is_it) return std::nullopt;
    const auto value = line.substr(name.size());
    return value.substr(std::min(value.find_first_not_of(' '), value.size()));
  };
  if (const auto status = value_of("grpc-status:")) status_ = number_in<int>(*status);
  if (const auto message = value_of("grpc-message:")) message_ = decoded(*message);
  return true;
}

}  // namespace mlcca::cluster::grpc
