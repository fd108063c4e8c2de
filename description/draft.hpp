// SPDX-License-Identifier: BSD-2-Clause
// Drafts: the description between XML and System. Values are converted, but names are not resolved
// to indices yet. Members that a draft cannot fill are listed as "without ..."
#pragma once
#include <cstdint>
#include <deque>
#include <optional>
#include <string>
#include <vector>

#include "core/model/system.hpp"
#include "description/attributes.hpp"
#include "description/problems.hpp"
#include "description/read.hpp"
#include "description/xml.hpp"

namespace mlcca::description {

/// The content of an <Attributes> or <Provision> element.
struct StatedDraft {
  AttributeSet set;
  std::vector<UserValueDraft> user;
  std::optional<int> priority;
  core::Origin origin;
};

/// A definition of a user-defined attribute.
struct UserAttributeDraft {
  core::UserAttribute attribute;
  Dimension dimension;
};

/// An event channel with the attribute sets that it states.
struct ChannelDraft {
  core::EventChannel channel;  ///< without attributes
  std::vector<StatedDraft> sets;
};

/// How frames of a channel are identified on a network.
struct BindingDraft {
  std::string channel;
  std::string element;    ///< name of the element that states the identifier: ETag, Identifier, …;
                          ///< empty if there is none
  core::Binding binding;  ///< without channel and destination
  std::optional<unsigned> destination;
};

/// The names of the two nodes of a link.
struct NodePairDraft {
  std::string from;
  std::string to;
  core::Origin origin;
};

/// A described link of a mesh.
struct MeshLinkDraft {
  NodePairDraft ends;
  core::mesh::DescribedLink link;  ///< without ends
  bool both_ways = true;
};

/// A described contention domain of a mesh, with the links that share its time.
struct MeshDomainDraft {
  core::mesh::DescribedDomain domain;  ///< without links
  std::vector<NodePairDraft> members;
};

/// A node of a mesh; `gateway` is the name of the gateway that it is, empty if it is none.
struct MeshNodeDraft {
  core::mesh::Node node;  ///< without gateway
  std::string gateway;
};

/// What a network states about its mesh.
struct MeshDraft {
  core::mesh::Mesh mesh;  ///< without nodes, links, domains
  StatedDraft per_hop;
  bool states_hops = false;
  std::vector<MeshNodeDraft> nodes;
  std::vector<MeshLinkDraft> links;
  std::vector<MeshDomainDraft> domains;
};

/// What a network or a port states about control traffic.
struct ControlDraft {
  std::string kinds;
  std::uint32_t rate = 0;
  std::string user;  ///< for a port only

  [[nodiscard]] bool states_something() const {
    return !kinds.empty() || rate != 0 || !user.empty();
  }
};

/// A network with its medium, provision and bindings.
struct NetworkDraft {
  core::Network network;  ///< without mesh, provision and bindings
  ControlDraft control;
  std::optional<core::Origin> bus;  ///< where its Bus element is
  std::optional<MeshDraft> mesh;
  StatedDraft provision;
  std::vector<BindingDraft> bindings;
};

/// A port by which a gateway is connected to a network.
struct PortDraft {
  std::string network;
  core::Port port;     ///< without network and sender
  std::string sender;  ///< user name or number
  std::optional<unsigned> node;
  bool states_queue = false;  ///< it states something that only CAN has
  ControlDraft control;
};

/// A gateway with its provision and ports.
struct GatewayDraft {
  core::Gateway gateway;  ///< without provision and ports
  StatedDraft provision;
  std::vector<PortDraft> ports;
};

/// Where something is located, and what identifies it as a sender; for an end, a component or a
/// placement.
struct SeatDraft {
  std::string network;
  std::string gateway;
  std::string mesh_node;
  std::string user;
  std::string address;
  std::optional<unsigned> node;
  std::optional<unsigned> priority;
};

/// A publisher or subscriber.
struct EndDraft {
  std::string name;
  std::string channel;
  SeatDraft seat;
  std::uint32_t component = core::kNoComponent;  ///< index into Draft::components
  std::string group;
  std::string unit;
  std::vector<StatedDraft> own;
  core::Origin origin;
};

/// A component, which groups publishers and subscribers at one place.
struct ComponentDraft {
  core::Component component;  ///< without place
  SeatDraft seat;
};

/// A statement outside of a component about where that is.
struct PlacementDraft {
  std::string component;
  SeatDraft seat;
  core::Origin origin;
};

/// One place of a declared route: a network or gateway.
struct HopDraft {
  std::string place;
  core::Origin origin;
};

/// A declared route.
struct RouteDraft {
  std::vector<HopDraft> places;  ///< including both ends
  core::Origin origin;
};

/// All parts of a description. Lists from which resolve() removes many entries one by one are
/// deques, so that the draft and the System together need little more memory than one of them.
struct Draft {
  std::string name;
  std::vector<UserAttributeDraft> user_attributes;
  std::deque<ChannelDraft> channels;
  std::vector<NetworkDraft> networks;
  std::vector<GatewayDraft> gateways;
  std::vector<ComponentDraft> components;
  std::vector<PlacementDraft> placements;
  std::vector<RouteDraft> routes;
  std::deque<EndDraft> publishers;
  std::deque<EndDraft> subscribers;
};

/// Adds a valid child of System to the draft. Reports attributes with a wrong unit or value.
void add_part(const Element& part, Draft& draft, Problems& problems);

/// Resolves all names and builds the System. It reports references to unknown names, entries at a
/// wrong place, and parts that are not allowed at their place. An entry gets into the System only
/// if all of its references are known, so that all indices in the System are valid.
core::System resolve(Draft draft, Problems& problems, Users users = Users::of_this_machine);

}  // namespace mlcca::description
