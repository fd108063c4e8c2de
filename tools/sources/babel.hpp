// SPDX-License-Identifier: BSD-2-Clause
// babeld's local interface: what this machine sees of its neighbours, and its routes.
#pragma once
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>

#include "daemon/net/sources/bounds.hpp"
#include "daemon/net/sources/source.hpp"

namespace mlcca::net {

namespace babel {

// babeld states no more of each; of routes only those to a single host count.
inline constexpr std::size_t kMaxInterfaces = 64;
inline constexpr std::size_t kMaxNeighbours = 1024;
inline constexpr std::size_t kMaxRoutes = 4096;  ///< and as many prefixes of its own
inline constexpr std::size_t kMaxWords = 64;     ///< of a line
inline constexpr std::size_t kMaxWord = 128;     ///< bytes

/// How a line ends or does not end a reply. `too_much`: it exceeds one of the bounds above.
enum class Line : std::uint8_t { fact, other, ok, refused, too_much };

/// What babeld has reported. Its lines are fed in order; those it does not know are ignored.
class State {
 public:
  /// `described`: addresses that the description gives its nodes. babeld names a neighbour by its
  /// link-local address; one whose own host route is described is named by that.
  explicit State(Described described) : described_(std::move(described)) {}

  Line take(std::string_view line);
  /// Of the links, `taken` is left to the caller.
  [[nodiscard]] core::mesh::Snapshot snapshot() const;

 private:
  struct Interface {
    std::string ipv6;
    std::string ipv4;
  };
  struct Neighbour {
    std::string address;
    std::string interface;
    std::uint32_t rxcost = 0;
    std::uint32_t txcost = 0;
    std::uint32_t cost = 0;
  };
  struct Route {
    std::string host;
    std::string via;
    std::uint32_t refmetric = 0;
    bool installed = false;
  };
  using Fields = std::map<std::string_view, std::string_view>;
  // False: there is no room for it.
  bool take_entry(std::string_view kind, const std::string& id, const Fields& fields);
  bool take_interface(const std::string& name, const Fields& fields);
  bool take_neighbour(const std::string& id, const Fields& fields);
  bool take_route(const std::string& id, const Fields& fields);
  bool take_own_prefix(const std::string& id, const Fields& fields);
  void flush(std::string_view kind, const std::string& id);
  /// By the address of a neighbour: the described host that it is.
  using Names = std::map<std::string_view, std::string>;
  [[nodiscard]] Names neighbours_by_host() const;
  [[nodiscard]] std::string own_host() const;
  [[nodiscard]] std::string own_name(const std::string& interface, const std::string& host) const;
  [[nodiscard]] std::string neighbour_name(const std::string& address, const Names& hosts) const;

  Described described_;
  std::map<std::string, Interface> interfaces_;
  std::map<std::string, Neighbour> neighbours_;
  std::map<std::string, Route> routes_;
  std::map<std::string, std::string> own_hosts_;  ///< by the name of the xroute
};

/// Share of the packets that are lost, 1e-9, where a link costs `cost`: 1 - 256/cost, rounded up;
/// 65535 and more: all. Nothing below 256: such a cost does not come from counting.
[[nodiscard]] std::optional<Value> loss_of(std::uint32_t cost);

/// "10.9.3.1" of "10.9.3.1/32"; nothing of a prefix that holds more than one host.
[[nodiscard]] std::optional<std::string> host_of(std::string_view prefix);

}  // namespace babel

/// `source.endpoint`: HOST:PORT, [HOST]:PORT or the path of a socket.
[[nodiscard]] Result<std::unique_ptr<LinkSource>> open_babel(const core::mesh::Source& source,
                                                             const core::mesh::Mesh& mesh,
                                                             sd_event* loop,
                                                             LinkSource::Report report);

}  // namespace mlcca::net
