// SPDX-License-Identifier: BSD-2-Clause
// Writes a DBC file of the messages that are admitted on a network.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <iterator>
#include <map>
#include <set>
#include <utility>

#include "base/ascii.hpp"
#include "base/many.hpp"
#include "core/profiles/profile.hpp"
#include "mlcca/attribute.hpp"
#include "tools/design/export/admitted.hpp"
#include "tools/values.hpp"

namespace mlcca::tools::design {
namespace {

constexpr std::size_t kMostDbcName = 32;  // as long as most tools accept
constexpr std::uint32_t kClassicFrame = 8;
constexpr std::uint32_t kFdFrame = 64;
constexpr double kNanosOfMilli = 1e6;

bool is_of_dbc_name(char c) { return is_alphanumeric(c) || c == '_'; }

/// The names of a DBC file: letters, digits and '_', all different.
class DbcNames {
 public:
  const std::string& of(const std::string& name) {
    const auto [known, is_new] = known_.try_emplace(name);
    if (is_new) known->second = take(name);
    return known->second;
  }
  std::string take(const std::string& name) {
    std::string wanted;
    for (const char c : name) wanted += is_of_dbc_name(c) ? c : '_';
    if (wanted.empty() || is_digit(wanted.front())) wanted.insert(0, "_");
    wanted.resize(std::min(wanted.size(), kMostDbcName));
    auto taken = wanted;
    for (unsigned i = 2; !taken_.insert(taken).second; ++i) {
      const auto tail = fmt::format("_{}", i);
      taken = wanted.substr(0, kMostDbcName - tail.size()) + tail;
    }
    return taken;
  }

 private:
  std::set<std::string> taken_;
  std::map<std::string, std::string> known_;
};

std::string in_dbc_quotes(std::string_view text) {
  std::string out;
  for (const char c : text) {
    if (c == '"') out += '\\';
    out += c == '\\' ? '/' : c;  // a backslash would escape a quote after it
  }
  return out;
}

class DbcWriter {
 public:
  DbcWriter(const Admitted& admitted, std::size_t network)
      : system_(admitted.system()), network_(system_.networks[network]) {
    frames_ = frames_on(admitted, network, out_.lacks);
  }

  Exported write() {
    for (const auto& frames : frames_) add(frames);
    out_.text = fmt::format("VERSION \"\"\n\nNS_ :\n\nBS_:\n\nBU_:{}\n\n", nodes_);
    out_.text += messages_;
    out_.text += fmt::format("CM_ \"Network {} of {}: what mlccactl check admits.\";\n",
                             network_.name, system_.name);
    out_.text += comments_;
    definitions();
    out_.text += values_;
    return std::move(out_);
  }

 private:
  template <class... T>
  static void put(std::string& to, fmt::format_string<T...> format, T&&... values) {
    fmt::format_to(std::back_inserter(to), format, std::forward<T>(values)...);
  }

  const std::string& node(const std::string& name) {
    const auto& known = names_of_nodes_.of(name);
    if (seen_.insert(known).second) nodes_ += " " + known;
    return known;
  }

  void add(const AdmittedFrames& frames) {
    const auto& channel = system_.channels[frames.channel];
    const auto& publisher = system_.publishers[frames.publisher];
    const auto* binding = network_.binding_of(frames.channel);
    const auto& offered = core::attributes_in(publisher, frames.set);
    if (binding->is_masked())
      return out_.lacks.add("range", "a range of identifiers is no message: left out", 0,
                            channel.name);
    const auto all =
        core::kExtendedFlag | (binding->extended ? core::kExtendedBits : core::kStandardBits);
    if ((~frames.identity.mask & all) != 0)
      out_.lacks.add("open", "bits of the identifier that the description leaves open are 0", 0,
                     fmt::format("{} of {}", channel.name, publisher.name));
    const bool fd = binding->format != core::FrameFormat::classic;
    const auto most = fd ? kFdFrame : kClassicFrame;
    Value bytes = offered.has(Attribute::max_payload) ? offered[Attribute::max_payload] : most;
    const bool long_group = has_groups_ && bytes > kClassicFrame;
    if (bytes > most && !long_group) {
      out_.lacks.add("fragments", "events of several frames: the message is one frame", 0,
                     fmt::format("{}: {}", channel.name, many(bytes, "byte")));
      bytes = most;
    }
    // One message for each identifier, even if several publishers are admitted with it.
    if (!ids_.insert(frames.identity.id).second)
      return out_.lacks.add("repeated", "the identifier is a message already", 0,
                            fmt::format("{} of {}", channel.name, publisher.name));
    message(frames, channel, bytes);
    period(frames.identity.id, offered, channel.arrival);
    values(frames.identity.id, fd, binding->extended);
    rest(channel, offered);
  }

  void message(const AdmittedFrames& frames, const core::EventChannel& channel, Value bytes) {
    put(messages_, "BO_ {} {}: {} {}\n", frames.identity.id, names_of_messages_.take(channel.name),
        bytes, node(frames.sender));
    std::vector<std::string> receivers;
    receivers.reserve(frames.receivers.size());
    for (const auto& receiver : frames.receivers) receivers.push_back(node(receiver));
    const auto by = receivers.empty() ? std::string("Vector__XXX")
                                      : fmt::format("{}", fmt::join(receivers, ","));
    for (Value at = 0, number = 0; at < bytes; at += kClassicFrame, ++number) {
      const auto bits = 8 * std::min<Value>(kClassicFrame, bytes - at);
      put(messages_, " SG_ Data{} : {}|{}@1+ (1,0) [0|0] \"\" {}\n", number, 8 * at, bits, by);
    }
    messages_ += '\n';
    if (!channel.description.empty())
      put(comments_, "CM_ BO_ {} \"{}\";\n", frames.identity.id,
          in_dbc_quotes(channel.description));
  }

  /// The Period is the cycle time, or of sporadic events their least distance.
  void period(std::uint32_t id, const AttributeSet& offered, core::Arrival arrival) {
    const bool sporadic = arrival == core::Arrival::sporadic;
    any_sporadic_ = any_sporadic_ || sporadic;
    if (sporadic) put(values_, "BA_ \"GenMsgSendType\" BO_ {} 1;\n", id);
    if (!offered.has(Attribute::period)) return;
    const auto ns = offered[Attribute::period];
    put(values_, "BA_ \"{}\" BO_ {} {};\n", sporadic ? "GenMsgDelayTime" : "GenMsgCycleTime", id,
        static_cast<double>(ns) / kNanosOfMilli);
    whole_ = whole_ && ns % static_cast<Value>(kNanosOfMilli) == 0;
  }

  void values(std::uint32_t id, bool fd, bool extended) {
    constexpr int standard_fd = 14;
    constexpr int group = 3;
    int format = (fd ? standard_fd : 0) + (extended ? 1 : 0);
    if (has_groups_) format = group;
    if (format != 0) put(values_, "BA_ \"VFrameFormat\" BO_ {} {};\n", id, format);
    any_fd_ = any_fd_ || fd;
  }

  /// Writes the attributes for which DBC files have no attribute into the comment of the message.
  void rest(const core::EventChannel& channel, const AttributeSet& offered) {
    std::string words;
    for (std::size_t i = 0; i < kAttributes; ++i) {
      const auto a = attribute_at(i);
      if (a == Attribute::period || a == Attribute::max_payload || !offered.has(a)) continue;
      words += (words.empty() ? "" : ", ") + std::string(info(a).name) + " " +
               print_value(info(a).name, offered[a], info(a).unit);
    }
    if (!words.empty())
      out_.lacks.add("attributes", "have no counterpart", 0,
                     fmt::format("{}: {}", channel.name, words));
  }

  void definitions() {
    auto& out = out_.text;
    const char* const number = whole_ ? "INT" : "FLOAT";
    put(out, "BA_DEF_ BO_ \"GenMsgCycleTime\" {} 0 3600000;\n", number);
    if (any_sporadic_)
      put(out,
          "BA_DEF_ BO_ \"GenMsgDelayTime\" {} 0 3600000;\n"
          "BA_DEF_ BO_ \"GenMsgSendType\" ENUM \"Cyclic\",\"Event\";\n"
          "BA_DEF_DEF_ \"GenMsgDelayTime\" 0;\nBA_DEF_DEF_ \"GenMsgSendType\" \"Cyclic\";\n",
          number);
    out +=
        "BA_DEF_ BO_ \"VFrameFormat\" ENUM \"StandardCAN\",\"ExtendedCAN\",\"reserved\","
        "\"J1939PG\"";
    constexpr int reserved = 10;
    for (int i = 0; i < reserved; ++i) out += ",\"reserved\"";
    out +=
        ",\"StandardCAN_FD\",\"ExtendedCAN_FD\";\n"
        "BA_DEF_ \"BusType\" STRING ;\nBA_DEF_ \"ProtocolType\" STRING ;\n"
        "BA_DEF_ \"Baudrate\" INT 0 1000000;\nBA_DEF_ \"BaudrateCANFD\" INT 0 8000000;\n"
        "BA_DEF_DEF_ \"GenMsgCycleTime\" 0;\nBA_DEF_DEF_ \"VFrameFormat\" \"StandardCAN\";\n"
        "BA_DEF_DEF_ \"BusType\" \"CAN\";\nBA_DEF_DEF_ \"ProtocolType\" \"\";\n"
        "BA_DEF_DEF_ \"Baudrate\" 0;\nBA_DEF_DEF_ \"BaudrateCANFD\" 0;\n";
    if (any_fd_) out += "BA_ \"BusType\" \"CAN FD\";\n";
    if (has_groups_) put(out, "BA_ \"ProtocolType\" \"{}\";\n", protocol_);
    if (network_.bus.bitrate != 0) put(out, "BA_ \"Baudrate\" {};\n", network_.bus.bitrate);
    if (network_.bus.data_bitrate != 0)
      put(out, "BA_ \"BaudrateCANFD\" {};\n", network_.bus.data_bitrate);
  }

  const core::System& system_;
  const core::Network& network_;
  const std::string_view protocol_ = core::traits_of(network_.profile).dbc_protocol;
  const bool has_groups_ = !protocol_.empty();  ///< messages are parameter groups, and not frames
  std::vector<AdmittedFrames> frames_;
  Exported out_;
  DbcNames names_of_nodes_;
  DbcNames names_of_messages_;
  std::set<std::string> seen_;
  std::set<std::uint32_t> ids_;
  std::string nodes_;
  std::string messages_;
  std::string comments_;
  std::string values_;
  bool whole_ = true;
  bool any_fd_ = false;
  bool any_sporadic_ = false;
};

}  // namespace

Exported export_dbc(const Admitted& admitted, std::size_t network) {
  return DbcWriter(admitted, network).write();
}

}  // namespace mlcca::tools::design
