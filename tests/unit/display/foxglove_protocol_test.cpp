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
  EXPECT_FALSE(live.contains("dataStartTime"));

  const json replay =
      json::parse(server_info_message({.name = "roseau",
                                       .sends_time = true,
                                       .data_range = {{host_time_from_ns(5'000'000'007), host_time_from_ns(9'000'000'000)}}}));
  EXPECT_THAT(replay["capabilities"], testing::Contains("time"));
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

TEST(FoxgloveProtocol, RefusesBinaryRequestsWithWords) {
  EXPECT_THAT(refuse_client_binary(""), testing::HasSubstr("empty"));
  EXPECT_THAT(refuse_client_binary("\x01xx"), testing::HasSubstr("publishing"));
  EXPECT_THAT(refuse_client_binary("\x02"), testing::HasSubstr("/api/action"));
  EXPECT_THAT(refuse_client_binary("\xff"), testing::HasSubstr("255"));
}

}  // namespace
}  // namespace roseau::display
