#include "recorder/format/topics.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "schema/schemas.h"

namespace roseau::mcap {
namespace {

using ::testing::HasSubstr;

StreamInfo sonic() {
  return {
      .topic = "/sonic/wind", .kind = "wind", .role = StreamRole::derived, .device = "sonic", .metadata = {{"axes", "uvw"}}};
}

TEST(Topics, StreamsGoIntoChannelsAndBack) {
  for (std::size_t i = 0; i < kSampleKindCount; ++i) {
    const auto kind = static_cast<SampleKind>(i);
    for (const auto role : {StreamRole::raw, StreamRole::derived, StreamRole::health}) {
      StreamInfo stream = sonic();
      stream.kind = to_string(kind);
      stream.role = role;
      const Schema schema = make_schema(kind, 3);
      const Channel channel = make_channel(stream, 7, schema.id);
      const auto back = stream_info_from(channel, &schema);
      ASSERT_TRUE(back) << back.error().message;
      EXPECT_EQ(back->topic, stream.topic);
      EXPECT_EQ(back->kind, stream.kind);
      EXPECT_EQ(back->role, role);
      EXPECT_EQ(back->device, stream.device);
      EXPECT_EQ(back->metadata, stream.metadata);
    }
  }
}

TEST(Topics, ChannelsOfOtherProgramsAreTakenByTheirSchema) {
  const Schema schema{1, "foxglove.RawImage", "protobuf", ""};
  const auto stream = stream_info_from({.id = 1, .schema_id = 1, .topic = "cam", .message_encoding = "protobuf"}, &schema);
  ASSERT_TRUE(stream);
  EXPECT_EQ(stream->topic, "/cam");
  EXPECT_EQ(stream->kind, "frame");
  EXPECT_EQ(stream->role, StreamRole::raw);
}

TEST(Topics, CodedPicturesHaveTheirOwnMessage) {
  StreamInfo stream{.topic = "/camera0/image", .kind = "frame", .device = "camera0"};
  EXPECT_EQ(storage_of(stream), ImageStorage::raw);
  EXPECT_EQ(make_schema(stream, 1).name, "foxglove.RawImage");
  stream.metadata["storage"] = "raw";
  EXPECT_EQ(make_schema(stream, 1).name, "foxglove.RawImage");
  for (const std::string storage : {"png", "jpeg"}) {
    stream.metadata["storage"] = storage;
    EXPECT_EQ(to_string(storage_of(stream)), storage);
    const Schema schema = make_schema(stream, 1);
    EXPECT_EQ(schema.name, "foxglove.CompressedImage");
    const auto back = stream_info_from(make_channel(stream, 7, 1), &schema);
    ASSERT_TRUE(back) << back.error().message;
    EXPECT_EQ(back->kind, "frame");
    EXPECT_EQ(back->metadata, stream.metadata);
  }
  // Another program's: recorded again as they are.
  const Schema schema = make_schema(stream, 1);
  const auto other = stream_info_from({.id = 1, .schema_id = 1, .topic = "/cam", .message_encoding = "protobuf"}, &schema);
  ASSERT_TRUE(other);
  EXPECT_EQ(other->metadata.at("storage"), "as_received");
  EXPECT_NE(storage_of(*other), ImageStorage::raw);
  // What is no picture has no storage.
  EXPECT_EQ(storage_of({.topic = "/a", .kind = "wind", .metadata = {{"storage", "png"}}}), ImageStorage::raw);
}

TEST(Topics, WhatANewerProgramWroteIsNamed) {
  const Schema schema{1, "roseau.LeafArea", "protobuf", ""};
  Channel channel = make_channel(sonic(), 1, 1);
  channel.metadata["roseau.kind"] = "leaf_area";
  const auto stream = stream_info_from(channel, &schema);
  ASSERT_FALSE(stream);
  EXPECT_EQ(stream.error().code, ErrorCode::unsupported);
  EXPECT_THAT(stream.error().message, HasSubstr("/sonic/wind"));
  EXPECT_THAT(stream.error().message, HasSubstr("roseau.LeafArea"));
  EXPECT_FALSE(stream_info_from({.topic = "/text", .message_encoding = "json"}, nullptr));
  Channel other_role = make_channel(sonic(), 1, 1);
  other_role.metadata["roseau.role"] = "imagined";
  const Schema wind = make_schema(SampleKind::wind, 1);
  EXPECT_THAT(stream_info_from(other_role, &wind).error().message, HasSubstr("imagined"));
}

TEST(Topics, SessionInfoGoesBothWays) {
  const SessionInfo info{schema::kSchemaVersion, "0.1.0", Duration{-5}, {{"site", "Inra"}}};
  const auto back = session_info_from(to_metadata(info));
  ASSERT_TRUE(back) << back.error().message;
  EXPECT_EQ(back->program_version, "0.1.0");
  EXPECT_EQ(back->utc_minus_host_time, Duration{-5});
  EXPECT_EQ(back->other, info.other);
  EXPECT_FALSE(session_info_from(to_metadata(SessionInfo{.schema_version = 1}))->utc_minus_host_time);
}

TEST(Topics, ANewerSchemaVersionIsRefusedWithBothVersions) {
  const auto newer = session_info_from(to_metadata(SessionInfo{schema::kSchemaVersion + 1, "9.9", {}, {}}));
  ASSERT_FALSE(newer);
  EXPECT_EQ(newer.error().code, ErrorCode::unsupported);
  EXPECT_THAT(newer.error().message, HasSubstr("roseau 9.9"));
  EXPECT_THAT(newer.error().message, HasSubstr("up to " + std::to_string(schema::kSchemaVersion)));
  EXPECT_EQ(session_info_from({"roseau", {}}).error().code, ErrorCode::corrupt);
}

TEST(Topics, CountersGoBothWaysAndSkipNewWords) {
  const TopicCounters counters{{"/a", {1, 2, 3, 4, 5, 6}}, {"/b", {.received = 18'000'000'000'000'000'000U}}};
  auto metadata = to_metadata(counters);
  metadata.metadata["/a"] += " squeezed=7";
  const auto back = counters_from(metadata);
  ASSERT_TRUE(back);
  EXPECT_EQ(back->at("/a").received, 1U);
  EXPECT_EQ(back->at("/a").recorded, 2U);
  EXPECT_EQ(back->at("/a").dropped, 3U);
  EXPECT_EQ(back->at("/a").gaps, 4U);
  EXPECT_EQ(back->at("/a").bad, 5U);
  EXPECT_EQ(back->at("/a").late, 6U);
  EXPECT_EQ(back->at("/b").received, 18'000'000'000'000'000'000U);
  EXPECT_FALSE(counters_from({"roseau.counters", {{"/a", "received=many"}}}));
}

TEST(Topics, CountersOfAPartHoldTheSessionsToo) {
  const TopicCounters file{{"/a", {.received = 1, .recorded = 3, .repeated = 2}}};
  const TopicCounters session{{"/a",
                               {.received = 9,
                                .recorded = 5,
                                .dropped = 10,
                                .dropped_intake = 1,
                                .dropped_queue = 2,
                                .dropped_encoder = 3,
                                .dropped_write = 4}},
                              {"/b", {.received = 7}}};
  const auto metadata = to_metadata(file, session);
  const auto file_back = counters_from(metadata);
  ASSERT_TRUE(file_back);
  EXPECT_EQ(file_back->at("/a").recorded, 3U);
  EXPECT_EQ(file_back->at("/a").repeated, 2U);
  EXPECT_EQ(file_back->at("/a").dropped, 0U);
  EXPECT_EQ(file_back->at("/b").received, 0U);
  const auto session_back = session_counters_from(metadata);
  ASSERT_TRUE(session_back);
  EXPECT_EQ(session_back->at("/a").recorded, 5U);
  EXPECT_EQ(session_back->at("/a").dropped_intake, 1U);
  EXPECT_EQ(session_back->at("/a").dropped_queue, 2U);
  EXPECT_EQ(session_back->at("/a").dropped_encoder, 3U);
  EXPECT_EQ(session_back->at("/a").dropped_write, 4U);
  EXPECT_EQ(session_back->at("/a").repeated, 0U);
  EXPECT_EQ(session_back->at("/b").received, 7U);
  // A file that was never split says it once.
  EXPECT_EQ(session_counters_from(to_metadata(file))->at("/a").recorded, 3U);
}

TEST(Topics, PartsOfASessionSayTheirNumber) {
  const SessionInfo info{.schema_version = 1, .session_id = "20260801-0a1b", .part = 3, .repeated_messages = 2};
  const auto back = session_info_from(to_metadata(info));
  ASSERT_TRUE(back) << back.error().message;
  EXPECT_EQ(back->session_id, "20260801-0a1b");
  EXPECT_EQ(back->part, 3U);
  EXPECT_EQ(back->repeated_messages, 2U);
  EXPECT_TRUE(back->other.empty());
  const auto old = session_info_from(to_metadata(SessionInfo{.schema_version = 1}));
  EXPECT_EQ(old->session_id, "");
  EXPECT_EQ(old->part, 1U);
  auto broken = to_metadata(info);
  broken.metadata["part"] = "third";
  EXPECT_EQ(session_info_from(broken).error().code, ErrorCode::corrupt);
}

TEST(Topics, TimesBeforeZeroBecomeZero) {
  EXPECT_EQ(log_time_from(host_time_from_ns(-5)), 0U);
  EXPECT_EQ(log_time_from(host_time_from_ns(5)), 5U);
  EXPECT_EQ(to_ns(host_time_from(~std::uint64_t{0})), std::numeric_limits<std::int64_t>::max());
}

}  // namespace
}  // namespace roseau::mcap
