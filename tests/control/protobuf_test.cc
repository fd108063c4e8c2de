// SPDX-License-Identifier: BSD-2-Clause
// Our codec against protobuf's own: what one writes the other reads, and neither reads what the
// other refuses.
#include <google/protobuf/descriptor.h>
#include <google/protobuf/message.h>
#include <google/protobuf/stubs/logging.h>
#include <google/protobuf/util/message_differencer.h>
#include <gtest/gtest.h>

#include <random>
#include <string>

#include "control/fields.hpp"
#include "control/wire.hpp"
#include "mlcca/v1/control.pb.h"
#include "tests/control/messages.hpp"

namespace mlcca::control {
namespace {

using google::protobuf::FieldDescriptor;
using google::protobuf::Message;
using google::protobuf::util::MessageDifferencer;

/// Messages with fields at random, each list of at most three elements.
class Random {
 public:
  void fill(Message& message) {
    const auto* type = message.GetDescriptor();
    for (int i = 0; i < type->field_count(); ++i) {
      const auto* field = type->field(i);
      if (field->real_containing_oneof() == nullptr && below(2) == 0) set(message, *field);
    }
    for (int i = 0; i < type->real_oneof_decl_count(); ++i) {
      const auto* oneof = type->oneof_decl(i);
      set(message, *oneof->field(static_cast<int>(below(oneof->field_count()))));
    }
  }
  std::uint64_t below(int n) { return engine_() % static_cast<std::uint64_t>(n); }

 private:
  void set(Message& message, const FieldDescriptor& field) {
    const auto& as = *message.GetReflection();
    const bool list = field.is_repeated();
    for (std::uint64_t n = list ? below(4) : 1; n > 0; --n) {
      switch (field.cpp_type()) {
        case FieldDescriptor::CPPTYPE_MESSAGE:
          fill(list ? *as.AddMessage(&message, &field) : *as.MutableMessage(&message, &field));
          break;
        case FieldDescriptor::CPPTYPE_STRING:
          list ? as.AddString(&message, &field, text()) : as.SetString(&message, &field, text());
          break;
        case FieldDescriptor::CPPTYPE_UINT64:
          list ? as.AddUInt64(&message, &field, number())
               : as.SetUInt64(&message, &field, number());
          break;
        case FieldDescriptor::CPPTYPE_UINT32:
          as.SetUInt32(&message, &field, static_cast<std::uint32_t>(number()));
          break;
        case FieldDescriptor::CPPTYPE_BOOL:
          as.SetBool(&message, &field, below(2) == 1);
          break;
        case FieldDescriptor::CPPTYPE_ENUM:
          as.SetEnumValue(&message, &field,
                          static_cast<int>(below(field.enum_type()->value_count())));
          break;
        default:
          FAIL() << field.full_name() << " is of a type that this test does not know";
      }
    }
  }
  std::uint64_t number() { return engine_() >> below(64); }
  std::string text() {
    static const char* const kTexts[] = {"", "can0", "Größe", "\u2028", "\U0001F6D1", "0x4e6f"};
    return kTexts[below(std::size(kTexts))];
  }

  std::mt19937_64 engine_{20261124};
};

template <class Wire, class Plain>
void agree_over_random_messages(Result<Plain> (*read)(std::string_view)) {
  Random random;
  for (int i = 0; i < 1000; ++i) {
    Wire wire;
    random.fill(wire);
    const auto plain = read(wire.SerializeAsString());
    ASSERT_TRUE(plain) << plain.error().text << "\n" << wire.DebugString();
    std::string bytes;
    write(*plain, bytes);
    Wire back;
    ASSERT_TRUE(back.ParseFromString(bytes)) << wire.DebugString();
    // A message that is always there is written also where the other side left it out.
    const auto again = read(back.SerializeAsString());
    ASSERT_TRUE(again);
    EXPECT_EQ(*again, *plain) << wire.DebugString();
  }
}

TEST(Protobuf, ReadsWhatWeWriteAndWritesWhatWeRead) {
  agree_over_random_messages<v1::Request>(read_request);
  agree_over_random_messages<v1::Reply>(read_reply);
}

/// To the byte: all fields of all messages that the other tests have.
TEST(Protobuf, WritesTheSameBytes) {
  const auto expect_same = [](auto wire, const auto& message, const std::string& name) {
    std::string bytes;
    write(message, bytes);
    ASSERT_TRUE(wire.ParseFromString(bytes)) << name;
    EXPECT_EQ(wire.SerializeAsString(), bytes) << name;
  };
  for (const auto& named : test::all_requests())
    expect_same(v1::Request(), named.request, named.name);
  for (const auto& named : test::all_replies()) expect_same(v1::Reply(), named.reply, named.name);
}

template <class Wire, class Plain>
void refuse_what_protobuf_refuses(Result<Plain> (*read)(std::string_view)) {
  google::protobuf::SetLogHandler(nullptr);
  Random random;
  int refused = 0;
  for (int i = 0; i < 4000; ++i) {
    Wire wire;
    random.fill(wire);
    std::string bytes = wire.SerializeAsString();
    for (std::uint64_t n = 1 + random.below(3); n > 0 && !bytes.empty(); --n) {
      const auto at = random.below(static_cast<int>(bytes.size()));
      if (random.below(4) == 0)
        bytes.resize(at);
      else
        bytes[at] = static_cast<char>(random.below(256));
    }
    if (Wire().ParseFromString(bytes)) continue;
    ++refused;
    EXPECT_FALSE(read(bytes)) << ::testing::PrintToString(bytes);
  }
  EXPECT_GT(refused, 400) << "hardly anything was wrong, so hardly anything tested";
}

TEST(Protobuf, RefusesNothingThatWeRead) {
  refuse_what_protobuf_refuses<v1::Request>(read_request);
  refuse_what_protobuf_refuses<v1::Reply>(read_reply);
}

/// A number of another kind than control.proto says, where protobuf would ignore the field.
TEST(Protobuf, AFieldOfAnotherKindIsMalformed) {
  EXPECT_FALSE(read_request("\x0a\x01x\x12"));                     // id as a text
  EXPECT_FALSE(read_request(std::string("\x10\x00", 2)));          // status as a number
  EXPECT_FALSE(read_request(std::string("\x12\x00\x90\x01", 4)));  // slices without a value
}

}  // namespace
}  // namespace mlcca::control
