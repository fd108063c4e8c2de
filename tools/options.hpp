// SPDX-License-Identifier: BSD-2-Clause
// The command line: which verb, its arguments, and how to talk and print.
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

/// Arguments of all verbs; each takes the ones that its Takes names.
struct Arguments {
  std::string channel;
  std::string subject;                   ///< of a channel that is not described
  std::vector<std::string> identifiers;  ///< NETWORK=ID
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
  std::string when_clean;  ///< a span of time
  std::string report;      ///< of audit mode
  bool xml = false;        ///< what a description lacks, alone
  std::string key;         ///< the user's own name of an admission
  std::string lease;       ///< a span of time
  bool hold = false;
  std::string role;
  std::string end;                 ///< its name
  std::vector<std::string> state;  ///< attributes that the program was made with
  bool follow = false;
  std::string place;
  std::string part;                ///< of a cluster, or what is done with it
  std::string network;             ///< of what is reserved
  std::string gateway;             ///< the same, or the one that is meant
  bool yes = false;                ///< do it without asking back
  bool until_restart = false;      ///< drain: no longer than mlccad runs
  bool html = false;               ///< a page
  bool check = false;              ///< only the health, for a monitoring system
  bool verify = false;             ///< never seen: see is_read_back()
  std::vector<std::string> links;  ///< "[NETWORK/]FROM,TO=RATE"
  bool one_way = false;
  std::vector<std::string> without;
  std::string kind;
  std::string since;  ///< a moment
  std::string until;
  std::uint32_t limit = 0;  ///< 0: the daemon's
  BandwidthArguments bandwidth;
  TopArguments top;
};

enum class Takes : std::uint8_t {
  nothing,
  withdrawal,  ///< a channel, and whether to ask back
  check,       ///< perhaps as a monitoring system asks
  channel,
  delivery,      ///< a channel, and the ends that shall be added to it
  announcement,  ///< a channel, and the end of it that a program is
  reservation,   ///< a delivery, and for how long it is admitted
  admission,     ///< a channel, or the id of an admission
  lease,         ///< the id or the key of an admission
  mode,
  findings,  ///< of audit mode, and in which form
  place,     ///< perhaps a network or gateway
  gate,      ///< perhaps an interface or network
  changes,   ///< links as they might be, and what might be gone
  past,      ///< of which channel, kind and time
  links,     ///< rates of a chain of links
  form,      ///< in which to print
  cluster,   ///< which part, of what, and whether to ask back
  screen,    ///< how often, and what of it
};

struct Options {
  std::string socket;
  bool json = false;
  Color color = Color::no;  ///< of standard output
  Color error_color = Color::no;
  std::chrono::milliseconds patience{};
};

struct Verb {
  const char* name;
  const char* help;
  Takes takes;
  Exit (*run)(const Options& options, const Arguments& arguments);
};

/// A command line that is to be carried out.
struct Command {
  const Verb* verb = nullptr;
  Options options;
  Arguments arguments;
};

/// The command, or how to exit because everything has been said: help, version, or what is wrong.
std::variant<Command, Exit> parse(std::span<const Verb> verbs, int argc, const char* const* argv);

}  // namespace mlcca::tools
