// SPDX-License-Identifier: BSD-2-Clause
// What every format that is imported becomes: one network, its nodes, its messages.
#pragma once
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <tuple>
#include <vector>

#include "base/result.hpp"
#include "core/model/system.hpp"
#include "mlcca/attribute.hpp"
#include "tools/design/import/lacks.hpp"
#include "tools/design/import/text.hpp"

namespace mlcca::tools::design {

struct ImportedNode {
  std::string name;
  std::string description;
  std::optional<std::uint8_t> number;  ///< of a sender, where the profile has one
};

/// An end of a message: who, and how it differs from the message.
struct ImportedEnd {
  std::size_t node = 0;                ///< index into ImportedNetwork::nodes
  std::optional<std::uint8_t> number;  ///< that it sends as; none: the node's own
  AttributeSet attributes;             ///< of its own, in place of those of the message
};

struct ImportedMessage {
  std::string name;
  std::string description;
  std::string type;  ///< of its data; empty: the format knows none
  int line = 0;
  std::string file;      ///< where the line is; empty: the file of the network
  std::uint32_t id = 0;  ///< as of core::Binding
  bool extended = false;
  std::string topic;  ///< what it is known by where there is no Binding
  core::FrameFormat format{};
  std::optional<std::uint8_t> priority;     ///< j1939, cyphal
  std::optional<std::uint8_t> destination;  ///< j1939
  AttributeSet attributes;
  std::string remark;  ///< what was assumed of it, for a comment; empty: nothing
  std::vector<ImportedEnd> senders;
  std::vector<ImportedEnd> receivers;  ///< each once
};

/// As receivers that require nothing of their own.
std::vector<ImportedEnd> receivers_of(const std::vector<std::size_t>& nodes);
void remove_receiver(ImportedMessage& message, std::size_t node);
/// Of two ends at one node the stricter attributes count.
void add_receiver(ImportedMessage& message, const ImportedEnd& end);

struct ImportedNetwork {
  std::string file;
  std::string name;
  std::string remark;  ///< what is to be known of it, for a comment; empty: nothing
  core::NetworkKind kind{};
  core::Profile profile{};
  std::uint32_t bitrate = 0;       ///< bit/s, 0: not stated
  std::uint32_t data_bitrate = 0;  ///< bit/s, 0: no FD frames
  bool is_part = false;            ///< files of other nodes of the same network may follow
  std::vector<ImportedNode> nodes;
  std::vector<ImportedMessage> messages;
  Lacks lacks;
  bool is_merged = false;  ///< of several files
};

/// Adds to the lacks of the network, with the line of the message in its file.
void add_lack(ImportedNetwork& network, std::string_view kind, std::string_view what,
              const ImportedMessage& message, const std::string& item);

/// Of a text that does not say how it is encoded: `read` gets it in UTF-8, and what it was is
/// listed.
template <class Read>
Result<ImportedNetwork> read_as_utf8(std::string_view text, const Read& read) {
  bool converted = false;
  const std::string readable = utf8_of(text, converted);
  Result<ImportedNetwork> out = read(std::string_view(readable));
  if (out && converted) out->lacks.add("encoding", "is no UTF-8", 0, "read as Windows-1252");
  return out;
}

/// Whether the profile has such a number, and events of that size. If not, why not is added to the
/// lacks of the network: the message is left out.
bool is_bindable(ImportedNetwork& network, const ImportedMessage& message);

/// Messages of a network, of which those with one identity become one.
class Joiner {
 public:
  explicit Joiner(ImportedNetwork& network);
  /// `file` says in a list where it comes from; empty: from the file of the network.
  void add(ImportedMessage message, std::string_view file);

 private:
  /// Topic, identifier, whether it is extended.
  using Identity = std::tuple<std::string, std::uint32_t, bool>;
  static Identity identity_of(const ImportedMessage& message);
  void join(ImportedMessage& into, ImportedMessage from);

  ImportedNetwork& network_;
  std::map<Identity, std::size_t> known_;
};

/// Puts what another file says of the same network to it: a message of both has the ends of both.
void merge(ImportedNetwork& into, ImportedNetwork from);

/// What is left to be said when all files of a network are read: bit rates that none states, and
/// messages that only receivers are known of. Those are published by a node for all of them, unless
/// the profile wants to know its number.
void complete(ImportedNetwork& network);

/// What the command line says of every file.
struct ImportOptions {
  Value default_period = 100'000'000;  ///< ns, of a message that states no cycle
  std::uint32_t bitrate = 0;           ///< bit/s, 0: what the file states
  std::uint32_t data_bitrate = 0;
  std::optional<core::Profile> profile;  ///< none: what the file is
  unsigned node = 0;                     ///< CANopen, Cyphal, 1 to 127; 0: what the file states
};

/// Largest file, bytes.
inline constexpr std::size_t kMostImported = std::size_t{32} << 20U;
inline constexpr std::size_t kMostMessages = 65'536;
inline constexpr std::size_t kMostNodes = 4'096;
inline constexpr std::size_t kMostReceivers = 262'144;  ///< of all messages together
inline constexpr std::uint32_t kAssumedBitrate = 500'000;
inline constexpr std::uint32_t kAssumedDataBitrate = 2'000'000;

}  // namespace mlcca::tools::design
