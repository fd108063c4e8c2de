// SPDX-License-Identifier: BSD-2-Clause
#include "tools/sources/endpoint.hpp"

#include <arpa/inet.h>
#include <netinet/in.h>

#include <cstdint>
#include <cstring>
#include <optional>
#include <string_view>
#include <utility>

#include "base/number.hpp"
#include "base/unix_address.hpp"

namespace mlcca::net {
namespace {

std::optional<std::uint16_t> parse_port(std::string_view text) {
  const auto port = number_in<std::uint16_t>(text);
  return port.value_or(0) == 0 ? std::nullopt : port;
}

/// Converts an address of any family; the sockets API takes all through one type.
template <class Address>
Endpoint endpoint_of(const Address& address, std::string text) {
  static_assert(sizeof(Address) <= sizeof(sockaddr_storage));
  Endpoint out{.address = {}, .size = sizeof(Address), .text = std::move(text)};
  std::memcpy(&out.address, &address, sizeof(Address));
  return out;
}

Result<Endpoint> path_endpoint(const std::string& path) {
  const auto address = unix_address(path);
  if (!address) return std::unexpected(address.error());
  return endpoint_of(*address, path);
}

}  // namespace

Result<Endpoint> parse_endpoint(const std::string& text) {
  if (text.starts_with('/')) return path_endpoint(text);
  const auto colon = text.rfind(':');
  const auto port = colon == std::string::npos
                        ? std::nullopt
                        : parse_port(std::string_view(text).substr(colon + 1));
  if (port) {
    std::string host = text.substr(0, colon);
    if (host.starts_with('[') && host.ends_with(']')) host = host.substr(1, host.size() - 2);
    sockaddr_in v4{};
    v4.sin_family = AF_INET;
    v4.sin_port = htons(*port);
    if (::inet_pton(AF_INET, host.c_str(), &v4.sin_addr) == 1) return endpoint_of(v4, text);
    sockaddr_in6 v6{};
    v6.sin6_family = AF_INET6;
    v6.sin6_port = htons(*port);
    if (::inet_pton(AF_INET6, host.c_str(), &v6.sin6_addr) == 1) return endpoint_of(v6, text);
  }
  return fail("\"" + text +
              "\" is no endpoint: HOST:PORT with a numeric host (127.0.0.1:2009, [::1]:33123) or "
              "the absolute path of a socket");
}

}  // namespace mlcca::net
