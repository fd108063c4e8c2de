// SPDX-License-Identifier: BSD-2-Clause
// The common result of all imports: one network with its nodes and messages.
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

/// A node of the network.
struct ImportedNode {
  std::string name;
  std::string description;
  std::optional<std::uint8_t> number;  ///< number of a sender, in profiles that have one
};

/// A sender or receiver of a message, and how it differs from the message.
struct ImportedEnd {
  std::size_t node = 0;                ///< index into ImportedNetwork::nodes
  std::optional<std::uint8_t> number;  ///< the number that it sends with; nullopt: the node's own
  AttributeSet attributes;             ///< if not empty, these replace those of the message
};

/// A message or topic; it becomes an event channel.
struct ImportedMessage {
  std::string name;
  std::string description;
  std::string type;  ///< type of the data; empty: the format does not state it
  int line = 0;
  std::string file;      ///< the file with that line; empty: the file of the network
  std::uint32_t id = 0;  ///< as in core::Binding
  bool extended = false;
  std::string topic;  ///< its name in networks without Binding
  core::FrameFormat format{};
  /// Sporadic if a sender states no cycle: then silence means nothing.
  core::Arrival arrival{};
  std::optional<std::uint8_t> priority;     ///< j1939, cyphal
  std::optional<std::uint8_t> destination;  ///< j1939
  AttributeSet attributes;
  std::string remark;  ///< an assumption about it, for an XML comment; empty: none
  std::vector<ImportedEnd> senders;
  std::vector<ImportedEnd> receivers;  ///< without duplicates
};

/// Receivers without requirements of their own.
std::vector<ImportedEnd> receivers_of(const std::vector<std::size_t>& nodes);
void remove_receiver(ImportedMessage& message, std::size_t node);
/// Adds a receiver. If the node is a receiver already, the stricter attributes count.
void add_receiver(ImportedMessage& message, const ImportedEnd& end);

/// A network as one or several files describe it.
struct ImportedNetwork {
  std::string file;
  std::string name;
  std::string remark;  ///< information for an XML comment; empty: none
  core::NetworkKind kind{};
  core::Profile profile{};
  std::uint32_t bitrate = 0;       ///< bit/s; 0: not stated
  std::uint32_t data_bitrate = 0;  ///< bit/s; 0: no FD frames
  bool is_part = false;  ///< it may be one of several files of the same network, each for one node
  std::vector<ImportedNode> nodes;
  std::vector<ImportedMessage> messages;
  Lacks lacks;
  bool is_merged = false;  ///< it was merged from several files
};

/// Adds an item about a message to the lacks of the network, with the message's line.
void add_lack(ImportedNetwork& network, std::string_view kind, std::string_view what,
              const ImportedMessage& message, const std::string& item);

/// Calls `read` with the text in UTF-8. If the encoding had to be guessed, the lacks list that.
template <class Read>
Result<ImportedNetwork> read_as_utf8(std::string_view text, const Read& read) {
  bool converted = false;
  const std::string readable = utf8_of(text, converted);
  Result<ImportedNetwork> out = read(std::string_view(readable));
  if (out && converted) out->lacks.add("encoding", "is no UTF-8", 0, "read as Windows-1252");
  return out;
}

/// Whether the profile allows the identifier and the size of the message. If not, the reason is
/// added to the lacks of the network, and the caller leaves the message out.
bool is_bindable(ImportedNetwork& network, const ImportedMessage& message);

/// Adds messages to a network; messages with the same identity become one.
class Joiner {
 public:
  explicit Joiner(ImportedNetwork& network);
  /// Adds a message. `file` is its source for the lacks; empty: the file of the network.
  void add(ImportedMessage message, std::string_view file);

 private:
  /// Topic, identifier, and whether the identifier is extended.
  using Identity = std::tuple<std::string, std::uint32_t, bool>;
  static Identity identity_of(const ImportedMessage& message);
  void join(ImportedMessage& into, ImportedMessage from);

  ImportedNetwork& network_;
  std::map<Identity, std::size_t> known_;
};

/// Merges the network of another file into `into`; a message of both files has the ends of both.
void merge(ImportedNetwork& into, ImportedNetwork from);

/// Completes a network when all its files are read: it assumes bit rates that no file states, and
/// adds a publisher for messages that have only receivers, unless the profile requires its number.
void complete(ImportedNetwork& network);

/// Options of the command line for all files.
struct ImportOptions {
  Value default_period = 100'000'000;  ///< ns, for messages that state no cycle
  std::uint32_t bitrate = 0;           ///< bit/s; 0: as the file states
  std::uint32_t data_bitrate = 0;
  std::optional<core::Profile> profile;  ///< nullopt: by the kind of file
  unsigned node = 0;  ///< node-id for CANopen and Cyphal, 1 to 127; 0: as the file states
};

/// Largest file in bytes.
inline constexpr std::size_t kMostImported = std::size_t{32} << 20U;
inline constexpr std::size_t kMostMessages = 65'536;
inline constexpr std::size_t kMostNodes = 4'096;
inline constexpr std::size_t kMostReceivers = 262'144;  ///< of all messages together
inline constexpr std::uint32_t kAssumedBitrate = 500'000;
inline constexpr std::uint32_t kAssumedDataBitrate = 2'000'000;

}  // namespace mlcca::tools::design
