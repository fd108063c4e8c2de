// SPDX-License-Identifier: BSD-2-Clause
// The description between XML and System: values are converted, names are not yet looked up.
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

struct UserAttributeDraft {
  core::UserAttribute attribute;
  Dimension dimension;
};

struct ChannelDraft {
  core::EventChannel channel;  ///< without attributes
  std::vector<StatedDraft> sets;
};

struct BindingDraft {
  std::string channel;
  std::string element;    ///< that names it: ETag, Identifier, …; empty: none
  core::Binding binding;  ///< without channel and destination
  std::optional<unsigned> destination;
};

/// Names of the two nodes of a link.
struct NodePairDraft {
  std::string from;
  std::string to;
  core::Origin origin;
};

struct MeshLinkDraft {
  NodePairDraft ends;
  core::mesh::DescribedLink link;  ///< without ends
  bool both_ways = true;
};

struct MeshDomainDraft {
  core::mesh::DescribedDomain domain;  ///< without links
  std::vector<NodePairDraft> members;
};

struct MeshNodeDraft {
  core::mesh::Node node;  ///< without gateway
  std::string gateway;
};

struct MeshDraft {
  core::mesh::Mesh mesh;  ///< without nodes, links, domains
  StatedDraft per_hop;
  bool states_hops = false;
  std::vector<MeshNodeDraft> nodes;
  std::vector<MeshLinkDraft> links;
  std::vector<MeshDomainDraft> domains;
};

/// What a network or a port says about control traffic.
struct ControlDraft {
  std::string kinds;
  std::uint32_t rate = 0;
  std::string user;  ///< of a port

  [[nodiscard]] bool states_something() const {
    return !kinds.empty() || rate != 0 || !user.empty();
  }
};

struct NetworkDraft {
  core::Network network;  ///< without mesh, provision and bindings
  ControlDraft control;
  std::optional<core::Origin> bus;  ///< where its Bus stands
  std::optional<MeshDraft> mesh;
  StatedDraft provision;
  std::vector<BindingDraft> bindings;
};

struct PortDraft {
  std::string network;
  core::Port port;     ///< without network and sender
  std::string sender;  ///< a user's name or number
  std::optional<unsigned> node;
  bool states_queue = false;  ///< something that is for CAN only
  ControlDraft control;
};

struct GatewayDraft {
  core::Gateway gateway;  ///< without provision and ports
  StatedDraft provision;
  std::vector<PortDraft> ports;
};

/// Where something sits and what tells a sender apart: of an end, a component or a placement.
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

struct ComponentDraft {
  core::Component component;  ///< without place
  SeatDraft seat;
};

struct PlacementDraft {
  std::string component;
  SeatDraft seat;
  core::Origin origin;
};

struct HopDraft {
  std::string place;
  core::Origin origin;
};

struct RouteDraft {
  std::vector<HopDraft> places;  ///< both ends included
  core::Origin origin;
};

/// Deques where many entries are taken off one by one, so that draft and System together need
/// little more than one of them.
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

/// Adds what a valid child of System says. Reports attributes that have a wrong unit or value.
void add_part(const Element& part, Draft& draft, Problems& problems);

/// Looks up all names and builds the System. What refers to something unknown, stands at a wrong
/// place or has parts that its place does not know is reported; only an entry whose references are
/// all known gets into the System, so that its indices are valid.
core::System resolve(Draft draft, Problems& problems, Users users = Users::of_this_machine);

}  // namespace mlcca::description
