// SPDX-License-Identifier: BSD-2-Clause
// The description between XML and System: values are converted, names are not yet looked up.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "core/system.hpp"
#include "description/problems.hpp"
#include "description/xml.hpp"

namespace mlcca::description {

struct BindingDraft {
  std::string channel;
  bool etag = false;      ///< named by ETag; otherwise by Identifier
  core::Binding binding;  ///< without channel
};

struct NetworkDraft {
  core::Network network;  ///< without bindings
  std::vector<BindingDraft> bindings;
};

struct PortDraft {
  std::string network;
  core::Port port;  ///< without network
};

struct GatewayDraft {
  core::Gateway gateway;  ///< without ports
  std::vector<PortDraft> ports;
};

/// A publisher or subscriber.
struct EndDraft {
  std::string name;
  std::string channel;
  std::string network;
  std::string gateway;
  std::string user;
  std::optional<unsigned> node;
  std::optional<unsigned> priority;
  AttributeSet own;
  core::Origin origin;
};

struct Draft {
  std::string name;
  std::vector<core::EventChannel> channels;
  std::vector<NetworkDraft> networks;
  std::vector<GatewayDraft> gateways;
  std::vector<EndDraft> publishers;
  std::vector<EndDraft> subscribers;
};

/// Adds what a valid child of System says. Reports attributes that have a wrong unit or value.
void add_part(const Element& part, Draft& draft, Problems& problems);

/// Looks up all names and builds the System. What refers to something unknown, stands at a wrong
/// place or has parts that its place does not know is reported; only an entry whose references are
/// all known gets into the System, so that its indices are valid.
core::System resolve(Draft draft, Problems& problems);

}  // namespace mlcca::description
