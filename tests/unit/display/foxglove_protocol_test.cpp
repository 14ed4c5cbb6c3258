#include "display/foxglove_protocol.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

namespace roseau::display {
namespace {

using nlohmann::json;

TEST(FoxgloveProtocol, ChoosesTheFirstNameItSpeaks) {
  EXPECT_EQ(choose_subprotocol("foxglove.sdk.v1"), "foxglove.sdk.v1");
  EXPECT_EQ(choose_subprotocol("foxglove.websocket.v1"), "foxglove.websocket.v1");
  EXPECT_EQ(choose_subprotocol("foxglove.websocket.v1, foxglove.sdk.v1"), "foxglove.websocket.v1");
  EXPECT_EQ(choose_subprotocol("mqtt ,\tfoxglove.sdk.v1 "), "foxglove.sdk.v1");
  EXPECT_FALSE(choose_subprotocol("mqtt"));
  EXPECT_FALSE(choose_subprotocol("foxglove.sdk.v12"));
  EXPECT_FALSE(choose_subprotocol(""));
  EXPECT_FALSE(choose_subprotocol(",,,"));
}

TEST(FoxgloveProtocol, TellsAboutTheServer) {
  const json live = json::parse(server_info_message({.name = "roseau", .session_id = "s1", .metadata = {{"mode", "live"}}}));
  EXPECT_EQ(live["op"], "serverInfo");
  EXPECT_EQ(live["sessionId"], "s1");
  EXPECT_EQ(live["metadata"]["mode"], "live");
  EXPECT_THAT(live["capabilities"], testing::Not(testing::Contains("time")));
  EXPECT_THAT(live["capabilities"], testing::Not(testing::Contains("playbackControl")));
  EXPECT_FALSE(live.contains("dataStartTime"));

  const json replay = json::parse(server_info_message(
      {.name = "roseau", .data_range = {{host_time_from_ns(5'000'000'007), host_time_from_ns(9'000'000'000)}}}));
  EXPECT_THAT(replay["capabilities"], testing::IsSupersetOf({"time", "playbackControl"}));
  EXPECT_EQ(replay["dataStartTime"]["sec"], 5);
  EXPECT_EQ(replay["dataStartTime"]["nsec"], 7);
}

TEST(FoxgloveProtocol, AdvertisesChannels) {
  const std::vector<Channel> channels = {{.id = 4, .topic = "/sonic/wind", .schema_name = "roseau.Wind", .schema = "QUJD"}};
  const json message = json::parse(advertise_message(channels));
  EXPECT_EQ(message["op"], "advertise");
  ASSERT_EQ(message["channels"].size(), 1U);
  EXPECT_EQ(message["channels"][0]["id"], 4);
  EXPECT_EQ(message["channels"][0]["encoding"], "protobuf");
  EXPECT_EQ(message["channels"][0]["schemaEncoding"], "protobuf");
  EXPECT_EQ(message["channels"][0]["schema"], "QUJD");
}

TEST(FoxgloveProtocol, WritesMessagesLittleEndian) {
  const std::string head = message_data_header(0x01020304, host_time_from_ns(0x0102030405060708));
  EXPECT_EQ(head, std::string("\x01\x04\x03\x02\x01\x08\x07\x06\x05\x04\x03\x02\x01"));
  EXPECT_EQ(time_message(host_time_from_ns(1)), std::string("\x02\x01\0\0\0\0\0\0\0", 9));
}

// RFC 4648, section 10.
TEST(FoxgloveProtocol, CodesBase64) {
  EXPECT_EQ(base64(""), "");
  EXPECT_EQ(base64("f"), "Zg==");
  EXPECT_EQ(base64("fo"), "Zm8=");
  EXPECT_EQ(base64("foo"), "Zm9v");
  EXPECT_EQ(base64("foobar"), "Zm9vYmFy");
  EXPECT_EQ(base64("\xff\xfe\xfb"), "//77");
}

TEST(FoxgloveProtocol, ReadsSubscriptions) {
  const auto message =
      parse_client_text(R"({"op":"subscribe","subscriptions":[{"id":0,"channelId":3},{"id":4294967295,"channelId":7}]})");
  ASSERT_TRUE(message);
  const auto& subscribe = std::get<Subscribe>(*message);
  EXPECT_THAT(subscribe.subscriptions, testing::ElementsAre(testing::Pair(0U, 3U), testing::Pair(4294967295U, 7U)));
  const auto end = parse_client_text(R"({"op":"unsubscribe","subscriptionIds":[5]})");
  ASSERT_TRUE(end);
  EXPECT_THAT(std::get<Unsubscribe>(*end).subscriptions, testing::ElementsAre(5U));
}

TEST(FoxgloveProtocol, ReadsParameterRequests) {
  const auto message = parse_client_text(R"({"op":"getParameters","parameterNames":["mode"],"id":"r1"})");
  ASSERT_TRUE(message);
  EXPECT_THAT(std::get<GetParameters>(*message).names, testing::ElementsAre("mode"));
  EXPECT_EQ(std::get<GetParameters>(*message).request_id, "r1");
}

TEST(FoxgloveProtocol, SaysWhatItDoesNotOffer) {
  const auto message = parse_client_text(R"({"op":"setParameters","parameters":[]})");
  ASSERT_TRUE(message);
  EXPECT_THAT(std::get<NotOffered>(*message).what, testing::HasSubstr("setParameters"));
}

TEST(FoxgloveProtocol, AnswersNonsenseWithWords) {
  const std::vector<std::string> nonsense = {
      "",
      "hello",
      "[]",
      "null",
      "{",
      "{}",
      R"({"op":7})",
      R"({"op":"dance"})",
      R"({"op":"subscribe"})",
      R"({"op":"subscribe","subscriptions":{}})",
      R"({"op":"subscribe","subscriptions":[1]})",
      R"({"op":"subscribe","subscriptions":[{"id":-1,"channelId":3}]})",
      R"({"op":"subscribe","subscriptions":[{"id":1.5,"channelId":3}]})",
      R"({"op":"subscribe","subscriptions":[{"id":4294967296,"channelId":3}]})",
      R"({"op":"subscribe","subscriptions":[{"id":1}]})",
      R"({"op":"unsubscribe","subscriptionIds":["1"]})",
      R"({"op":"getParameters","parameterNames":[1]})",
      std::string("\xff\xfe{\"op\":\"x\"}"),
      std::string(100'000, '['),
  };
  for (const std::string& text : nonsense) {
    const auto message = parse_client_text(text);
    ASSERT_FALSE(message) << text.substr(0, 80);
    EXPECT_FALSE(message.error().message.empty());
    // What is told about it must be sendable, whatever it held.
    EXPECT_TRUE(json::accept(status_message(StatusLevel::error, message.error().message)));
  }
  EXPECT_TRUE(json::accept(status_message(StatusLevel::error, "\xff broken")));
}

// The layouts are those of reference clients and servers: written out byte by byte.
TEST(FoxgloveProtocol, WritesThePlayersState) {
  const std::string message = playback_state_message({.status = PlaybackStatus::ended,
                                                      .time = host_time_from_ns(0x0102030405060708),
                                                      .speed = 1.5F,
                                                      .did_seek = true,
                                                      .request_id = "r7"});
  EXPECT_EQ(message, std::string("\x05\x03\x08\x07\x06\x05\x04\x03\x02\x01\0\0\xc0\x3f\x01\x02\0\0\0r7", 21));
  const std::string plain = playback_state_message({.status = PlaybackStatus::paused});
  EXPECT_EQ(plain, std::string("\x05\x01\0\0\0\0\0\0\0\0\0\0\x80\x3f\0\0\0\0\0", 19));
}

std::string control_request(char command, std::string_view speed, char had_seek, std::string_view seek,
                            std::string_view id_bytes, std::string_view id) {
  return std::string("\x03") + command + std::string(speed) + had_seek + std::string(seek) + std::string(id_bytes) +
         std::string(id);
}
constexpr std::string_view kOneAndAHalf("\0\0\xc0\x3f", 4);
constexpr std::string_view kSeek("\x08\x07\x06\x05\x04\x03\x02\x01", 8);
constexpr std::string_view kTwo("\x02\0\0\0", 4);

TEST(FoxgloveProtocol, ReadsPlaybackControl) {
  const auto sought = parse_client_binary(control_request(1, kOneAndAHalf, 1, kSeek, kTwo, "r7"));
  ASSERT_TRUE(sought) << sought.error().message;
  EXPECT_FALSE(sought->play);
  EXPECT_EQ(sought->speed, 1.5F);
  EXPECT_EQ(sought->seek, host_time_from_ns(0x0102030405060708));
  EXPECT_EQ(sought->request_id, "r7");

  const auto playing = parse_client_binary(control_request(0, kOneAndAHalf, 0, kSeek, kTwo, "r7 and what newer clients say"));
  ASSERT_TRUE(playing);
  EXPECT_TRUE(playing->play);
  EXPECT_FALSE(playing->seek) << "the time means nothing when nothing was sought";
  EXPECT_EQ(playing->request_id, "r7");

  const auto far = parse_client_binary(control_request(0, kOneAndAHalf, 1, std::string(8, '\xff'), kTwo, "r7"));
  ASSERT_TRUE(far);
  EXPECT_EQ(far->seek, HostTime::max());
}

TEST(FoxgloveProtocol, AnswersMalformedPlaybackControlWithWords) {
  const std::string whole = control_request(1, kOneAndAHalf, 1, kSeek, kTwo, "r7");
  for (std::size_t bytes = 1; bytes < whole.size(); ++bytes) {
    const auto cut = parse_client_binary(whole.substr(0, bytes));
    ASSERT_FALSE(cut) << bytes;
    EXPECT_EQ(cut.error().code, ErrorCode::invalid_argument);
  }
  const std::string nan("\0\0\xc0\x7f", 4);
  const std::string infinite("\0\0\x80\x7f", 4);
  const std::string zero(4, '\0');
  const std::string negative("\0\0\x80\xbf", 4);
  for (const auto& speed : {nan, infinite, zero, negative}) {
    EXPECT_FALSE(parse_client_binary(control_request(0, speed, 0, kSeek, kTwo, "r7")));
  }
  EXPECT_FALSE(parse_client_binary(control_request(2, kOneAndAHalf, 0, kSeek, kTwo, "r7"))) << "no such command";
  EXPECT_FALSE(parse_client_binary(control_request(0, kOneAndAHalf, 0, kSeek, "\xff\xff\xff\xff", "r7")));
  const std::string long_id(2000, 'x');
  EXPECT_FALSE(parse_client_binary(control_request(0, kOneAndAHalf, 0, kSeek, std::string_view("\xd0\x07\0\0", 4), long_id)));
}

TEST(FoxgloveProtocol, RefusesOtherBinaryRequestsWithWords) {
  const auto words = [](std::string_view bytes) {
    const auto parsed = parse_client_binary(bytes);
    EXPECT_FALSE(parsed);
    return parsed ? std::string() : parsed.error().message;
  };
  EXPECT_THAT(words(""), testing::HasSubstr("empty"));
  EXPECT_THAT(words("\x01xx"), testing::HasSubstr("publishing"));
  EXPECT_THAT(words("\x02"), testing::HasSubstr("/api/action"));
  EXPECT_THAT(words("\xff"), testing::HasSubstr("255"));
}

}  // namespace
}  // namespace roseau::display
