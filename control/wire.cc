// SPDX-License-Identifier: BSD-2-Clause
#include "control/wire.hpp"

#include <concepts>
#include <cstdint>
#include <optional>
#include <protozero/pbf_reader.hpp>
#include <protozero/pbf_writer.hpp>
#include <type_traits>
#include <vector>

#include "control/fields.hpp"
#include "control/utf8.hpp"

namespace mlcca::control {
namespace {

using Kind = protozero::pbf_wire_type;

template <class T>
concept Enum = std::is_enum_v<T>;

/// To bytes: what has its default is left out.
class Writer {
 public:
  explicit Writer(std::string& bytes) : bytes_(bytes), to_(bytes) {}

  /// All but the field of number `but`.
  template <Message M>
  void fields(const M& from, std::uint32_t but = 0) {
    for_each_field(from, [this, but](const Field& field, const auto& member) {
      if (field.number != but) put(field.number, member);
    });
  }

 private:
  Writer(Writer& parent, std::uint32_t number) : bytes_(parent.bytes_), to_(parent.to_, number) {}

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
  template <Message M>
  void put_always(std::uint32_t number, const M& message) {
    const std::size_t before = bytes_.size();
    Writer(*this, number).fields(message);
    // Protozero takes back a message without content; that it is there says something.
    if (bytes_.size() == before) to_.add_message(number, std::string());
  }

  std::string& bytes_;
  protozero::pbf_writer to_;
};

struct Malformed {};

/// From bytes: of a field that comes twice the last one counts, lists and messages go on.
class Reader {
 public:
  explicit Reader(protozero::data_view bytes) : from_(bytes) {}

  /// True if there was one of the alternatives of the message.
  template <Message M>
  bool fields(M& to) {
    bool any = false;
    while (next()) {
      const std::uint32_t number = from_.tag();
      if (!with_field(to, number, [this](auto& member) { take(member); })) from_.skip();
      if constexpr (requires { is_alternative(to, number); })
        any = any || is_alternative(to, number);
    }
    return any;
  }

 private:
  /// The key of a field is a number of 32 bits; protozero would cut a longer one.
  bool next() {
    const auto before = from_.data();
    if (!from_.next()) return false;
    const std::size_t bytes = before.size() - from_.data().size();
    constexpr std::size_t most = 5;
    if (bytes > most || (bytes == most && static_cast<unsigned char>(before.data()[4]) > 0x0f))
      throw Malformed{};
    return true;
  }
  void expect(Kind kind) const {
    if (from_.wire_type() != kind) throw Malformed{};
  }

  /// Longer numbers than the field has bits are cut, as protobuf does it.
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
  template <Message M>
  void take(M& message) {
    expect(Kind::length_delimited);
    Reader(from_.get_view()).fields(message);
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
};

/// nullopt: without a body.
template <class M>
Result<std::optional<M>> read(std::string_view bytes) {
  try {
    M message;
    if (!Reader({bytes.data(), bytes.size()}).fields(message)) return std::nullopt;
    return message;
  } catch (const protozero::exception&) {
  } catch (const Malformed&) {
  }
  return fail("malformed message: not what mlcca/v1/control.proto describes");
}

template <class M>
Result<M> read_known(std::string_view bytes, const char* unknown) {
  auto message = read<M>(bytes);
  if (!message) return std::unexpected(std::move(message).error());
  if (!*message) return fail(unknown);
  return std::move(**message);
}

}  // namespace

void write(const Request& from, std::string& bytes) { Writer(bytes).fields(from); }
void write(const Reply& from, std::string& bytes) { Writer(bytes).fields(from); }
void write_without_id(const Reply& from, std::string& bytes) {
  Writer(bytes).fields(from, Reply::kIdNumber);
}

Result<Request> read_request(std::string_view bytes) {
  return read_known<Request>(bytes,
                             "unknown request: this mlccad does not know it; is the client newer?");
}

Result<Reply> read_reply(std::string_view bytes) {
  return read_known<Reply>(bytes, "unknown reply: this program does not know it; is mlccad newer?");
}

}  // namespace mlcca::control
