// SPDX-License-Identifier: BSD-2-Clause
// The simple types of system.xsd: what a value looks like, checked by plain functions. A test holds
// the table and the schema together.
#pragma once
#include <cstddef>
#include <span>
#include <string>
#include <string_view>

namespace mlcca::description {

/// One simple type. Exactly one of `fits`, `values`, `integer` and a length says what is right.
struct ValueType {
  std::string_view name;     ///< as in the schema
  std::string_view words;    ///< "it must be ..."; empty for an enumeration
  std::string_view pattern;  ///< as in the schema, or empty
  bool (*fits)(std::string_view) = nullptr;
  std::span<const std::string_view> values;  ///< of an enumeration
  bool integer = false;
  long least = 0;  ///< of an integer, inclusive
  long most = 0;
  std::size_t shortest = 0;  ///< in characters
  std::size_t longest = 0;   ///< in characters; 0: not limited
};

/// The types by the names that the schema gives them.
namespace type {
extern const ValueType kName, kChannelName, kHostName, kUserName, kInterfaceName, kDeviceText,
    kText, kSubject, kShortHex, kSmallNumber, kNumber, kMessagePriority, kControlKinds,
    kControlRate, kDecimal, kExponent, kMagnitude, kPortNumber, kBitrate, kDataBitrate,
    kAttributeName, kBetter, kComposition, kSafeSide, kSetPriority, kNetworkKind, kProfile,
    kFrameFormat, kIdentifierForm, kImportance, kErrorCount, kQueueing, kExcess, kFifoDepth,
    kQueueLength, kInterference, kHopCount, kPacketBytes, kHeaderBytes, kNodeAddress,
    kSenderAddress, kSubjectRange, kUnlistedCount, kLinkRate, kMediumNumber, kRateKind, kSourceKind,
    kLinkMetric, kForwarder, kBoolean, kRefused;
}  // namespace type

/// All of them.
std::span<const ValueType* const> value_types();

/// Whether the schema accepts `value`, whose white space is collapsed.
bool is_valid(const ValueType& type, std::string_view value);

/// What is wrong with a value that is not valid, and what would be right.
std::string explain(const ValueType& type, std::string_view value);

}  // namespace mlcca::description
