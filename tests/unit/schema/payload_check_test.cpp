// Payloads against the schemas in a file, beside libprotobuf.
#include "schema/payload_check.h"

#include <gmock/gmock.h>
#include <google/protobuf/descriptor.pb.h>
#include <google/protobuf/dynamic_message.h>
#include <google/protobuf/stubs/logging.h>
#include <gtest/gtest.h>

#include <random>

#include "schema/conversion.h"
#include "tests/support/samples.h"

namespace roseau::schema {
namespace {

using ::testing::HasSubstr;
namespace pb = google::protobuf;

std::vector<std::byte> bytes_of(const std::string& text) {
  const auto bytes = std::as_bytes(std::span(text));
  return {bytes.begin(), bytes.end()};
}

struct Sampled {
  Schema schema;
  std::vector<std::byte> message;
};

Sampled sampled(std::size_t kind) {
  StreamTable streams;
  FramePool pool(2, 64);
  Sampled made{schema_of(static_cast<SampleKind>(kind)), {}};
  serialize(testing::filled_sample(static_cast<SampleKind>(kind), streams, pool), streams, made.message);
  return made;
}

TEST(PayloadCheck, EveryMessageOfOursFitsItsOwnSchema) {
  for (std::size_t kind = 0; kind < kSampleKindCount; ++kind) {
    const auto [schema, message] = sampled(kind);
    const auto checker = PayloadChecker::make(schema.descriptor_set, std::string(schema.name));
    ASSERT_TRUE(checker) << checker.error().message;
    const auto checked = checker->check(message);
    EXPECT_TRUE(checked) << schema.name << ": " << checked.error().message;
  }
}

/// What libprotobuf refuses, so do we. (We are stricter: a field of another wire type is wrong here and unknown there.)
TEST(PayloadCheck, WhatLibprotobufRefusesIsRefused) {
  const pb::LogSilencer silence;  // it says on standard error what it refuses
  std::mt19937 random(4);
  std::uint64_t refused = 0;
  for (std::size_t kind = 0; kind < kSampleKindCount; ++kind) {
    const auto [schema, message] = sampled(kind);
    const auto checker = PayloadChecker::make(schema.descriptor_set, std::string(schema.name));
    ASSERT_TRUE(checker);
    pb::FileDescriptorSet set;
    ASSERT_TRUE(set.ParseFromArray(schema.descriptor_set.data(), static_cast<int>(schema.descriptor_set.size())));
    pb::DescriptorPool pool;
    for (const auto& file : set.file()) ASSERT_NE(pool.BuildFile(file), nullptr);
    pb::DynamicMessageFactory factory;
    const std::unique_ptr<pb::Message> judge(factory.GetPrototype(pool.FindMessageTypeByName(std::string(schema.name)))->New());
    for (int round = 0; round < 300; ++round) {
      auto mutated = message;
      for (unsigned i = 0; i <= random() % 3; ++i) mutated[random() % mutated.size()] = static_cast<std::byte>(random());
      if (random() % 3 == 0) mutated.resize(random() % mutated.size());
      judge->Clear();
      const bool fits = judge->ParseFromArray(mutated.data(), static_cast<int>(mutated.size()));
      if (fits) continue;
      ++refused;
      EXPECT_FALSE(checker->check(mutated)) << schema.name << " round " << round;
    }
  }
  EXPECT_GT(refused, 500U);
}

/// message Node { repeated int32 number = 1; string name = 2; Node next = 3; fixed64 stamp = 4; }
PayloadChecker node_checker() {
  pb::FileDescriptorSet set;
  auto* file = set.add_file();
  file->set_name("node.proto");
  file->set_package("other");
  file->set_syntax("proto3");
  auto* message = file->add_message_type();
  message->set_name("Node");
  const auto add = [message](const char* name, int number, pb::FieldDescriptorProto::Type type, bool repeated) {
    auto* field = message->add_field();
    field->set_name(name);
    field->set_number(number);
    field->set_type(type);
    field->set_label(repeated ? pb::FieldDescriptorProto::LABEL_REPEATED : pb::FieldDescriptorProto::LABEL_OPTIONAL);
    if (type == pb::FieldDescriptorProto::TYPE_MESSAGE) field->set_type_name(".other.Node");
  };
  add("number", 1, pb::FieldDescriptorProto::TYPE_INT32, true);
  add("name", 2, pb::FieldDescriptorProto::TYPE_STRING, false);
  add("next", 3, pb::FieldDescriptorProto::TYPE_MESSAGE, false);
  add("stamp", 4, pb::FieldDescriptorProto::TYPE_FIXED64, false);
  auto checker = PayloadChecker::make(set.SerializeAsString(), "other.Node");
  EXPECT_TRUE(checker);
  return *checker;
}

std::string fault_of(const std::string& message) {
  const auto checked = node_checker().check(bytes_of(message));
  return checked ? "" : checked.error().message;
}

TEST(PayloadCheck, FieldsAreCheckedByTheirType) {
  EXPECT_EQ(fault_of(std::string("\x08\x05\x12\x02hi", 6)), "");
  EXPECT_EQ(fault_of(std::string("\x0a\x02\x05\x06", 4)), "");  // packed
  EXPECT_EQ(fault_of(std::string("\xfa\x01\x01z", 4)), "");     // a field of a newer schema
  EXPECT_THAT(fault_of(std::string("\x0a\x02\x05\xff", 4)), HasSubstr("other.Node.number: ends in the middle of a number"));
  EXPECT_THAT(fault_of(std::string("\x12\x02\xff\xfe", 4)), HasSubstr("other.Node.name is not UTF-8"));
  EXPECT_THAT(fault_of(std::string("\x20\x01", 2)), HasSubstr("other.Node.stamp has wire type 0 instead of 1"));
  EXPECT_THAT(fault_of(std::string("\x1a\x02\x12\x07", 4)), HasSubstr("field 2 runs past the end"));
  EXPECT_THAT(fault_of(std::string("\x0c", 1)), HasSubstr("the end of a group that did not begin"));
  EXPECT_THAT(fault_of(std::string("\x00", 1)), HasSubstr("impossible field number"));
}

TEST(PayloadCheck, NestingIsBounded) {
  std::string message;
  for (int i = 0; i < 120; ++i) {
    std::string outer = "\x1a";
    for (std::size_t size = message.size();; size >>= 7U) {
      outer += static_cast<char>((size & 0x7F) | (size > 0x7F ? 0x80 : 0));
      if (size <= 0x7F) break;
    }
    message = outer + message;
  }
  EXPECT_THAT(fault_of(message), HasSubstr("nested too deeply"));
  EXPECT_THAT(fault_of(std::string(200, '\x2b')), HasSubstr("nested too deeply"));  // groups
}

TEST(PayloadCheck, SchemasThatAreNoneAreRefused) {
  EXPECT_FALSE(PayloadChecker::make("descriptors", "a.B"));
  EXPECT_FALSE(PayloadChecker::make("", "a.B"));
  pb::FileDescriptorSet set;
  auto* message = set.add_file()->add_message_type();
  message->set_name("A");
  auto* field = message->add_field();
  field->set_number(1);
  field->set_type(pb::FieldDescriptorProto::TYPE_MESSAGE);
  field->set_type_name(".Missing");
  const auto made = PayloadChecker::make(set.SerializeAsString(), "A");
  ASSERT_FALSE(made);
  EXPECT_THAT(made.error().message, HasSubstr("refers to Missing"));
}

}  // namespace
}  // namespace roseau::schema
