// SPDX-License-Identifier: BSD-2-Clause
// Parsing of the command line: the verb, its arguments, and options for the connection and for
// output.
#pragma once
#include <chrono>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "base/result.hpp"
#include "control/messages.hpp"
#include "tools/bandwidth.hpp"
#include "tools/exit.hpp"
#include "tools/table.hpp"
#include "tools/top/top.hpp"

namespace mlcca::tools {

/// The arguments of all verbs. Verb::takes determines which of them a verb accepts; the others keep
/// their defaults.
struct Arguments {
  std::string channel;
  std::string subject;                   ///< for a channel that is not described
  std::vector<std::string> identifiers;  ///< NETWORK=ID, as typed
  std::string from;
  std::string to;
  std::vector<std::string> require;
  std::vector<std::string> offer;
  std::optional<std::uint32_t> node;
  std::optional<std::uint32_t> priority;
  std::string user;
  std::string subscriber;
  std::string publisher;
  std::string from_node;
  std::string to_node;
  std::string address;
  std::optional<std::uint64_t> admission;
  std::string mode;
  std::string when_clean;  ///< a span of time, as typed
  std::string report;      ///< what audit mode reports
  bool xml = false;        ///< only the elements that the description lacks
  std::string key;         ///< a name that the user gives an admission
  std::string lease;       ///< a span of time, as typed
  bool hold = false;
  std::string role;
  std::string end;                 ///< name of the publisher or subscriber
  std::vector<std::string> state;  ///< attributes that the program was built with
  bool follow = false;
  std::string place;
  std::string part;            ///< which part of a cluster's state, or what to do with the cluster
  std::string network;         ///< the network whose reservations are shown
  std::string gateway;         ///< the gateway whose reservations are shown, or which is meant
  bool yes = false;            ///< do not ask for confirmation
  bool until_restart = false;  ///< drain: only until mlccad restarts
  bool html = false;           ///< print an HTML page
  bool check = false;          ///< print only the health, for a monitoring system
  bool verify = false;         ///< never set here: see is_read_back()
  std::vector<std::string> links;  ///< [NETWORK/]FROM,TO=RATE, as typed
  bool one_way = false;
  std::vector<std::string> without;
  std::string kind;
  std::string since;  ///< a moment, as typed
  std::string until;
  std::uint32_t limit = 0;  ///< entries; 0: the daemon's default
  BandwidthArguments bandwidth;
  TopArguments top;
};

/// What arguments a verb accepts.
enum class Takes : std::uint8_t {
  nothing,
  withdrawal,  ///< a channel, and whether to ask for confirmation
  check,       ///< whether to answer as monitoring systems need it
  channel,
  delivery,      ///< a channel, and endpoints to be added to it
  announcement,  ///< a channel, and which endpoint of it a program is
  reservation,   ///< a delivery, and how long its admission lasts
  admission,     ///< a channel, or the id of an admission
  lease,         ///< the id or the key of an admission
  mode,
  findings,  ///< which findings of audit mode, and in which form
  place,     ///< optionally a network or gateway
  gate,      ///< optionally an interface or network
  changes,   ///< assumed changes: link rates, and places that are gone
  past,      ///< a channel, kind and time of past events
  links,     ///< rates of a chain of links
  form,      ///< the output form
  cluster,   ///< which part of the cluster's state or which action, for what
  screen,    ///< refresh interval and content of the screen
};

/// Options that all verbs accept.
struct Options {
  std::string socket;
  bool json = false;
  Color color = Color::no;  ///< whether standard output is coloured
  Color error_color = Color::no;
  std::chrono::milliseconds patience{};
};

/// A verb that mlccactl carries out itself.
struct Verb {
  const char* name;
  const char* help;
  Takes takes;
  Exit (*run)(const Options& options, const Arguments& arguments);
};

/// A parsed command line.
struct Command {
  const Verb* verb = nullptr;
  Options options;
  Arguments arguments;
};

/// Parses the command line. An Exit means that there is nothing more to do: help, the version or an
/// error message was printed.
std::variant<Command, Exit> parse(std::span<const Verb> verbs, int argc, const char* const* argv);

}  // namespace mlcca::tools
