// SPDX-License-Identifier: BSD-2-Clause
#include "tools/design/import/draft.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <iterator>
#include <map>
#include <set>
#include <utility>

#include "base/ascii.hpp"
#include "base/hash.hpp"
#include "base/many.hpp"
#include "core/model/words.hpp"
#include "core/profiles/profile.hpp"
#include "tools/design/attribute_list.hpp"
#include "tools/elements.hpp"
#include "tools/escape.hpp"

namespace mlcca::tools::design {
namespace {

constexpr std::size_t kMostName = 63;  // as in descriptions

/// Makes names unique.
class NamesOnce {
 public:
  /// Returns `wanted`, or with `otherwise` appended, or with a number.
  std::string take(const std::string& wanted, std::string_view otherwise) {
    if (taken_.insert(wanted).second) return wanted;
    if (auto other = with(wanted, otherwise); taken_.insert(other).second) return other;
    for (auto& number = next_[wanted];; ++number)
      if (auto other = with(wanted, std::to_string(number + 2)); taken_.insert(other).second)
        return other;
  }

 private:
  static std::string with(const std::string& name, std::string_view tail) {
    const auto room = kMostName - std::min(kMostName - 1, tail.size() + 1);
    return name_from(fmt::format("{}.{}", name.substr(0, room), tail));
  }
  std::set<std::string> taken_;
  std::map<std::string, unsigned> next_;
};

class Writer {
 public:
  Writer(std::vector<ImportedNetwork>& networks, const DraftOptions& options)
      : networks_(networks), options_(options) {}

  std::string write() {
    name_all();
    out_ = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<!--\n";
    for (const auto& network : networks_)
      put("  Imported from {}: {}.\n", in_comment(network.file),
          many(network.messages.size(), "message"));
    out_ += "  What was assumed stands in comments like this one: look at each of them.\n-->\n";
    put("<System name=\"{}\">\n", options_.system);
    for (const auto& network : networks_) channels(network);
    for (const auto& network : networks_) this->network(network);
    if (!options_.gateway.empty()) gateway();
    for (const auto& network : networks_) components(network);
    out_ += "</System>\n";
    return std::move(out_);
  }

 private:
  template <class... T>
  void put(fmt::format_string<T...> format, T&&... values) {
    fmt::format_to(std::back_inserter(out_), format, std::forward<T>(values)...);
  }

  void name_all() {
    NamesOnce channels;
    NamesOnce components;
    std::set<std::uint64_t> subjects;
    for (auto& network : networks_) {
      for (auto& message : network.messages) {
        const auto name = channels.take(name_from(message.name), network.name);
        renamed(network, message, message.name, name);
        message.name = name;
        auto subject = subject_of(network.name, message);
        while (subject == 0 || !subjects.insert(subject).second) ++subject;
        subjects_.push_back(subject);
      }
      for (auto& node : network.nodes) {
        const auto name = components.take(name_from(node.name), network.name);
        renamed(network, {}, node.name, name);
        node.name = name;
      }
    }
  }

  static void renamed(ImportedNetwork& network, const ImportedMessage& of,
                      const std::string& before, const std::string& now) {
    if (before != now)
      add_lack(network, "renamed", "a name is taken, or is none of a description", of,
               fmt::format("{} is called {}", before, now));
  }

  void remark(std::string_view indent, std::string_view text) {
    if (!text.empty()) put("{}<!-- {} -->\n", indent, in_comment(text));
  }

  void description(std::string_view indent, std::string_view text) {
    if (const auto line = one_line(text); !line.empty())
      put("{}<Description>{}</Description>\n", indent, escaped(line));
  }

  void channels(const ImportedNetwork& network) {
    for (const auto& message : network.messages) {
      remark("  ", message.remark);
      put("  <EventChannel name=\"{}\"{}>\n    <SubjectUID>0x{:016x}</SubjectUID>\n", message.name,
          message.arrival == core::Arrival::sporadic ? " arrival=\"sporadic\"" : "",
          subjects_.at(next_subject_++));
      description("    ", message.description.empty() ? message.type : message.description);
      out_ += attribute_list("Attributes", message.attributes, "    ");
      out_ += "  </EventChannel>\n";
    }
  }

  void network(const ImportedNetwork& network) {
    remark("  ", network.remark);
    put("  <Network name=\"{}\">\n    <Kind>{}</Kind>\n", network.name,
        core::words::kNetworkKinds.of(network.kind));
    if (network.kind == core::NetworkKind::can) {
      put("    <Profile>{}</Profile>\n    <Bus bitrate=\"{}\"",
          core::words::kProfiles.of(network.profile), network.bitrate);
      if (network.data_bitrate != 0) put(" data-bitrate=\"{}\"", network.data_bitrate);
      out_ += "/>\n";
      for (const auto& message : network.messages) binding(network, message);
    } else {
      remark("    ",
             "Assumed: nothing is known of what this network gives, so that check compares "
             "publishers with subscribers. State what was measured, without dynamic.");
      out_ += "    <Provision dynamic=\"true\" latency=\"0ns\" period=\"1ns\" omission=\"0\"/>\n";
    }
    out_ += "  </Network>\n";
  }

  void binding(const ImportedNetwork& network, const ImportedMessage& message) {
    put("    <Binding channel=\"{}\"", message.name);
    if (message.format != core::FrameFormat::classic)
      put(" format=\"{}\"", core::words::kFrameFormats.of(message.format));
    out_ += '>';
    const bool states_form = core::traits_of(network.profile).form == core::IdentifierForm::stated;
    const std::uint32_t number =
        message.id | (states_form && message.extended ? core::kExtendedFlag : 0);
    out_ += binding_element(network.profile, number, message.priority, message.destination);
    out_ += "</Binding>\n";
  }

  void gateway() {
    constexpr Value millisecond = 1'000'000;
    remark("  ", "Assumed of the gateway: measure what it adds to the way of an event.");
    put("  <Gateway name=\"{}\">\n", options_.gateway);
    AttributeSet provision;
    provision.set(Attribute::latency, millisecond)
        .set(Attribute::jitter, millisecond)
        .set(Attribute::omission, 0);
    out_ += attribute_list("Provision", provision, "    ");
    for (std::size_t i = 0; i < networks_.size(); ++i)
      put("    <Port network=\"{}\"><Interface name=\"{}\"/></Port>\n", networks_[i].name,
          escaped(options_.interfaces.at(i)));
    out_ += "  </Gateway>\n";
  }

  /// For a node, the messages that it publishes and subscribes, by index, with the properties of
  /// that end.
  struct Ends {
    std::vector<std::pair<std::size_t, const ImportedEnd*>> published;
    std::vector<std::pair<std::size_t, const ImportedEnd*>> subscribed;
  };

  void components(const ImportedNetwork& network) {
    std::vector<Ends> ends(network.nodes.size());
    for (std::size_t m = 0; m < network.messages.size(); ++m) {
      for (const auto& sender : network.messages[m].senders)
        ends.at(sender.node).published.emplace_back(m, &sender);
      for (const auto& receiver : network.messages[m].receivers)
        ends.at(receiver.node).subscribed.emplace_back(m, &receiver);
    }
    for (std::size_t n = 0; n < ends.size(); ++n) component(network, network.nodes[n], ends[n]);
  }

  void component(const ImportedNetwork& network, const ImportedNode& node, const Ends& ends) {
    put(R"(  <Component name="{}" network="{}")", node.name, network.name);
    if (node.number) put(R"( node="{}")", *node.number);
    if (ends.published.empty() && ends.subscribed.empty() && node.description.empty()) {
      out_ += "/>\n";
      return;
    }
    out_ += ">\n";
    description("    ", node.description);
    for (const auto& [message, as] : ends.published)
      end("Publisher", network.messages[message], *as);
    for (const auto& [message, as] : ends.subscribed)
      end("Subscriber", network.messages[message], *as);
    out_ += "  </Component>\n";
  }

  void end(std::string_view element, const ImportedMessage& message, const ImportedEnd& as) {
    put("    <{} channel=\"{}\"{}", element, message.name,
        as.number ? fmt::format(" node=\"{}\"", *as.number) : std::string());
    if (as.attributes.empty()) {
      out_ += "/>\n";
      return;
    }
    out_ += ">\n" + attribute_list("Attributes", as.attributes, "      ");
    put("    </{}>\n", element);
  }

  std::vector<ImportedNetwork>& networks_;
  const DraftOptions& options_;
  std::string out_;
  std::vector<std::uint64_t> subjects_;
  std::size_t next_subject_ = 0;
};

}  // namespace

std::uint64_t subject_of(std::string_view network, const ImportedMessage& message) {
  const auto identity = message.topic.empty()
                            ? fmt::format("\n{}{:x}/{}", message.extended ? "x" : "", message.id,
                                          message.destination ? *message.destination + 1 : 0)
                            : fmt::format("\n{}", message.topic);
  auto subject = hash_of(identity, hash_of(network));
  // A hash of similar texts has similar leading bits; splitmix64 mixes them once more.
  subject = (subject ^ (subject >> 30U)) * 0xbf58476d1ce4e5b9;
  subject = (subject ^ (subject >> 27U)) * 0x94d049bb133111eb;
  return (subject ^ (subject >> 31U)) | 1U;
}

std::string name_from(std::string_view text) {
  std::string out;
  for (const char c : text)
    if (is_of_name(c))
      out += c;
    else if (!out.ends_with('-'))
      out += '-';
  if (out.empty() || !is_letter(out.front())) out.insert(0, "n");
  if (out.size() > kMostName) out.resize(kMostName);
  return out;
}

std::string draft_of(std::vector<ImportedNetwork>& networks, const DraftOptions& options) {
  return Writer(networks, options).write();
}

}  // namespace mlcca::tools::design
