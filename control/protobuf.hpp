// SPDX-License-Identifier: BSD-2-Clause
// The protobuf encoding for every message of the schemas: templates over the code that
// proto/protoc-gen-mlcca generates.
#pragma once
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <protozero/pbf_reader.hpp>
#include <protozero/pbf_writer.hpp>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "control/fields.hpp"
#include "control/utf8.hpp"

namespace mlcca::control {

template <class T>
concept Enum = std::is_enum_v<T>;

/// Encodes messages. Fields with their default value are left out, as in proto3.
class ProtobufWriter {
 public:
  explicit ProtobufWriter(std::string& bytes) : bytes_(bytes), to_(bytes) {}

  /// Encodes all fields of `from` except the one with number `but`.
  template <Message M>
  void fields(const M& from, std::uint32_t but = 0) {
    for_each_field(from, [this, but](const Field& field, const auto& member) {
      if (field.number != but) put(field.number, member);
    });
  }
  /// Encodes a message field even if it is empty.
  template <Message M>
  void put_always(std::uint32_t number, const M& message) {
    const std::size_t before = bytes_.size();
    ProtobufWriter(*this, number).fields(message);
    // Protozero removes a submessage without content, but its presence has a meaning.
    if (bytes_.size() == before) to_.add_message(number, std::string());
  }

 private:
  ProtobufWriter(ProtobufWriter& parent, std::uint32_t number)
      : bytes_(parent.bytes_), to_(parent.to_, number) {}

  template <std::unsigned_integral T>
  void put(std::uint32_t number, T value) {
    if (value != 0) put_always(number, value);
  }
  template <Enum T>
  void put(std::uint32_t number, T value) {
    put(number, static_cast<std::uint32_t>(value));
  }
  void put(std::uint32_t number, const std::string& text) {
    if (!text.empty()) put_always(number, text);
  }
  void put(std::uint32_t number, const Octets<const std::string>& octets) {
    if (!octets.bytes.empty()) to_.add_bytes(number, octets.bytes);
  }
  template <Message M>
  void put(std::uint32_t number, const M& message) {
    put_always(number, message);
  }
  template <class T>
  void put(std::uint32_t number, const std::optional<T>& value) {
    if (value) put_always(number, *value);
  }
  template <class T>
  void put(std::uint32_t number, const std::vector<T>& values) {
    if constexpr (std::unsigned_integral<T>)
      to_.add_packed_uint64(number, values.begin(), values.end());
    else
      for (const T& value : values) put_always(number, value);
  }

  template <std::unsigned_integral T>
  void put_always(std::uint32_t number, T value) {
    to_.add_uint64(number, value);
  }
  void put_always(std::uint32_t number, const std::string& text) {
    if (is_utf8(text))
      to_.add_string(number, text);
    else
      to_.add_string(number, to_utf8(text));
  }

  std::string& bytes_;
  protozero::pbf_writer to_;
};

/// Thrown for bytes that are not a valid message.
struct Malformed {};

/// What to do with a field that the schema does not have.
enum class UnknownField : std::uint8_t { skip, refuse };

/// Decodes messages. If a single field occurs twice the last value counts; lists are appended and
/// messages merged, as in protobuf. Throws Malformed or an exception of protozero.
class ProtobufReader {
 public:
  explicit ProtobufReader(protozero::data_view bytes, UnknownField unknown = UnknownField::skip)
      : from_(bytes), unknown_(unknown) {}

  /// Decodes all fields into `to`. Returns whether an alternative (oneof) of the message was
  /// present.
  template <Message M>
  bool fields(M& to) {
    bool any = false;  // NOLINT(misc-const-correctness): it changes where there are alternatives
    while (next()) {
      const std::uint32_t number = from_.tag();
      if (!with_field(to, number, [this](auto&& member) { take(member); })) skip();
      if constexpr (requires { is_alternative(to, number); })
        any = any || is_alternative(to, number);
    }
    return any;
  }

 private:
  using Kind = protozero::pbf_wire_type;

  /// Reads the key of the next field. It must fit 32 bits; protozero would truncate a longer one.
  bool next() {
    const auto before = from_.data();
    if (!from_.next()) return false;
    const std::size_t bytes = before.size() - from_.data().size();
    constexpr std::size_t most = 5;
    if (bytes > most || (bytes == most && static_cast<unsigned char>(before.data()[4]) > 0x0f))
      throw Malformed{};
    return true;
  }
  void skip() {
    if (unknown_ == UnknownField::refuse) throw Malformed{};
    from_.skip();
  }
  void expect(Kind kind) const {
    if (from_.wire_type() != kind) throw Malformed{};
  }

  /// A number with more bits than the field is truncated, as protobuf does it.
  template <std::unsigned_integral T>
  void take(T& value) {
    expect(Kind::varint);
    if constexpr (std::same_as<T, bool>)
      value = from_.get_uint64() != 0;
    else
      value = static_cast<T>(from_.get_uint64());
  }
  template <Enum T>
  void take(T& value) {
    expect(Kind::varint);
    const std::uint64_t number = from_.get_uint64();
    value = number <= static_cast<std::uint64_t>(last_of(T{})) ? static_cast<T>(number) : T{};
  }
  void take(std::string& text) {
    expect(Kind::length_delimited);
    const auto view = from_.get_view();
    text.assign(view.data(), view.size());
    if (!is_utf8(text)) throw Malformed{};
  }
  void take(const Octets<std::string>& octets) {
    expect(Kind::length_delimited);
    const auto view = from_.get_view();
    octets.bytes.assign(view.data(), view.size());
  }
  template <Message M>
  void take(M& message) {
    expect(Kind::length_delimited);
    ProtobufReader(from_.get_view(), unknown_).fields(message);
  }
  template <class T>
  void take(std::optional<T>& value) {
    if (!value) value.emplace();
    take(*value);
  }
  template <class T>
  void take(std::vector<T>& values) {
    if constexpr (std::unsigned_integral<T>) {
      if (from_.wire_type() == Kind::length_delimited) {
        for (const std::uint64_t value : from_.get_packed_uint64())
          values.push_back(static_cast<T>(value));
        return;
      }
    }
    take(values.emplace_back());
  }

  protozero::pbf_reader from_;
  UnknownField unknown_;
};

template <Message M>
struct Parsed {
  M message;
  bool has_body = false;  ///< an alternative (oneof) of the message was present
};

/// Decodes all of `bytes`; nullopt if they are malformed.
template <Message M>
std::optional<Parsed<M>> parse(std::string_view bytes, UnknownField unknown) {
  try {
    Parsed<M> parsed;
    parsed.has_body = ProtobufReader({bytes.data(), bytes.size()}, unknown).fields(parsed.message);
    return parsed;
  } catch (const protozero::exception&) {
    return std::nullopt;
  } catch (const Malformed&) {
    return std::nullopt;
  }
}

/// Encodes a message that only one version of a schema reads and writes: a file, or an entry of the
/// store.
std::string bytes_of(const Message auto& message) {
  std::string bytes;
  ProtobufWriter(bytes).fields(message);
  return bytes;
}

/// The reverse. Nullopt if the bytes are malformed or have a field that the schema does not have.
template <Message M>
std::optional<M> message_in(std::string_view bytes) {
  auto parsed = parse<M>(bytes, UnknownField::refuse);
  if (!parsed) return std::nullopt;
  return std::move(parsed->message);
}

}  // namespace mlcca::control
