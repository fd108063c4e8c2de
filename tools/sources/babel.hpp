// SPDX-License-Identifier: BSD-2-Clause
// The link source babel: reads from babeld's local interface what this machine sees of its
// neighbours and routes.
#pragma once
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>

#include "core/mesh/bounds.hpp"
#include "daemon/net/sources/source.hpp"

namespace mlcca::net {

namespace babel {

// Limits for what babeld may state. Of routes only those to a single host count.
inline constexpr std::size_t kMaxInterfaces = 64;
inline constexpr std::size_t kMaxNeighbours = 1024;
inline constexpr std::size_t kMaxRoutes = 4096;  ///< and as many prefixes of its own
inline constexpr std::size_t kMaxWords = 64;     ///< of a line
inline constexpr std::size_t kMaxWord = 128;     ///< bytes

/// What a line means. `fact` and `other` do not end a reply; `too_much`: a limit above is exceeded.
enum class Line : std::uint8_t { fact, other, ok, refused, too_much };

/// The state that babeld has reported. Its lines are given in order; unknown ones are ignored.
class State {
 public:
  /// `described` are the addresses of nodes in the description. babeld identifies a neighbour by
  /// its link-local address; if the neighbour's own host route is described, it is identified by
  /// that.
  explicit State(core::mesh::DescribedNodes described) : described_(std::move(described)) {}

  /// Takes the next line without its line ending.
  Line take(std::string_view line);
  /// The links; the caller sets `taken`.
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
  // False: there is no room for the entry.
  bool take_entry(std::string_view kind, const std::string& id, const Fields& fields);
  bool take_interface(const std::string& name, const Fields& fields);
  bool take_neighbour(const std::string& id, const Fields& fields);
  bool take_route(const std::string& id, const Fields& fields);
  bool take_own_prefix(const std::string& id, const Fields& fields);
  void flush(std::string_view kind, const std::string& id);
  /// For the address of a neighbour: the described host that it is.
  using Names = std::map<std::string_view, std::string>;
  [[nodiscard]] Names neighbours_by_host() const;
  [[nodiscard]] std::string own_host() const;
  [[nodiscard]] std::string own_name(const std::string& interface, const std::string& host) const;
  [[nodiscard]] std::string neighbour_name(const std::string& address, const Names& hosts) const;

  core::mesh::DescribedNodes described_;
  std::map<std::string, Interface> interfaces_;
  std::map<std::string, Neighbour> neighbours_;
  std::map<std::string, Route> routes_;
  std::map<std::string, std::string> own_hosts_;  ///< by the name of the xroute
};

/// The loss in 1e-9 for a link of `cost`: 1 - 256/cost, rounded up; from 65535 on, all packets.
/// Nullopt below 256, a cost that does not result from counting packets.
[[nodiscard]] std::optional<Value> loss_of(std::uint32_t cost);

/// "10.9.3.1" for "10.9.3.1/32"; nullopt for a prefix of more than one host.
[[nodiscard]] std::optional<std::string> host_of(std::string_view prefix);

}  // namespace babel

/// Opens the source; `source.endpoint` is HOST:PORT, [HOST]:PORT or the path of a socket.
[[nodiscard]] Result<std::unique_ptr<LinkSource>> open_babel(const core::mesh::Source& source,
                                                             const core::mesh::Mesh& mesh,
                                                             sd_event* loop,
                                                             LinkSource::Report report);

}  // namespace mlcca::net
