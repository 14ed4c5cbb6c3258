#include "display/hub.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <nlohmann/json.hpp>

#include "display/client_session.h"

namespace roseau::display {
namespace {

using nlohmann::json;

constexpr ChannelId kWind = 11;
constexpr ChannelId kHealth = 12;
constexpr ChannelId kPicture = 13;

/// A connection that sends nothing until it is asked to.
class FakeLink final : public WebSocketLink {
 public:
  void wake() override { ++wakes; }
  void close(std::string_view reason) override { closed = std::string(reason); }
  int wakes = 0;
  std::string closed;
};

struct Viewer {
  explicit Viewer(Hub& hub, std::string_view subprotocol = kSdkSubprotocol) : client(hub.make_client(subprotocol)) {
    client->on_open(link);
  }

  std::vector<OutMessage> read() {
    std::vector<OutMessage> messages;
    while (auto message = client->next_message()) messages.push_back(std::move(*message));
    return messages;
  }
  std::vector<json> read_texts() {
    std::vector<json> texts;
    for (const OutMessage& message : read()) {
      if (message.is_text) texts.push_back(json::parse(message.head));
    }
    return texts;
  }
  void subscribe(SubscriptionId id, ChannelId channel) {
    client->on_text(json({{"op", "subscribe"}, {"subscriptions", {{{"id", id}, {"channelId", channel}}}}}).dump());
  }

  FakeLink link;
  std::unique_ptr<WebSocketClient> client;
};

SharedBytes bytes(const std::string& text) {
  const auto* begin = reinterpret_cast<const std::byte*>(text.data());
  return std::make_shared<const std::vector<std::byte>>(begin, begin + text.size());
}

std::string text_of(const SharedBytes& payload) { return {reinterpret_cast<const char*>(payload->data()), payload->size()}; }

HostTime at(std::int64_t seconds) { return HostTime(std::chrono::seconds(seconds)); }

class HubTest : public testing::Test {
 protected:
  HubTest() {
    hub.add_channels({{.channel = {.id = kWind, .topic = "/sonic/wind"},
                       .retention = {.on_subscribe = 1, .for_history = std::chrono::seconds(60)}},
                      {.channel = {.id = kHealth, .topic = "/health"}, .retention = {.on_subscribe = 2}},
                      {.channel = {.id = kPicture, .topic = "/camera0/image"}, .retention = {}, .conflated = true}});
  }
  Demand demand;
  Hub hub{[] { return ServerInfo{.name = "roseau", .session_id = "s"}; }, {{"mode", "live"}, {"version", "1"}}, 2000, demand};
};

TEST_F(HubTest, GreetsWithServerInfoAndChannels) {
  Viewer viewer(hub);
  const auto texts = viewer.read_texts();
  ASSERT_EQ(texts.size(), 2U);
  EXPECT_EQ(texts[0]["op"], "serverInfo");
  EXPECT_EQ(texts[1]["op"], "advertise");
  EXPECT_EQ(texts[1]["channels"].size(), 3U);
  EXPECT_EQ(hub.counters().clients, 1U);
}

TEST_F(HubTest, DeliversToSubscribersOnlyWithTheirOwnIds) {
  Viewer first(hub);
  Viewer second(hub);
  first.subscribe(70, kWind);
  first.subscribe(71, kWind);
  first.read();
  second.read();
  hub.deliver(kWind, at(5), bytes("w"));
  const auto messages = first.read();
  ASSERT_EQ(messages.size(), 2U);
  EXPECT_EQ(messages[0].head, message_data_header(70, at(5)));
  EXPECT_EQ(messages[1].head, message_data_header(71, at(5)));
  EXPECT_TRUE(second.read().empty());
}

TEST_F(HubTest, SendsANewSubscriberWhatIsKept) {
  for (int i = 0; i < 5; ++i) hub.deliver(kHealth, at(i), bytes(std::to_string(i)));
  Viewer viewer(hub);
  viewer.read();
  viewer.subscribe(1, kHealth);
  const auto messages = viewer.read();
  ASSERT_EQ(messages.size(), 2U);
  EXPECT_EQ(text_of(messages[0].payload), "3");
  EXPECT_EQ(text_of(messages[1].payload), "4");
}

TEST_F(HubTest, KeepsAMinuteOfHistoryButSendsOnlyTheNewest) {
  for (int i = 0; i <= 100; ++i) hub.deliver(kWind, at(i), bytes("x"));
  Viewer viewer(hub);
  viewer.read();
  viewer.subscribe(1, kWind);
  EXPECT_EQ(viewer.read().size(), 1U);
  const auto history = hub.history(kWind);
  ASSERT_TRUE(history);
  const std::size_t one = 4 + 13 + 1;
  EXPECT_EQ(history->size() / one, 60U);
  EXPECT_EQ(history->substr(4, 13), message_data_header(0, at(41)));
  std::uint32_t length = 0;
  std::memcpy(&length, history->data(), 4);
  EXPECT_EQ(length, 14U);
  EXPECT_FALSE(hub.history(999));
}

TEST_F(HubTest, ForgetsThePlaceBeforeAJump) {
  hub.add_channels({{.channel = {.id = kStateChannel, .topic = "/display/state"}, .retention = {.on_subscribe = 1}}});
  Viewer viewer(hub);
  viewer.subscribe(1, kWind);
  viewer.subscribe(2, kPicture);
  viewer.read();
  hub.deliver(kStateChannel, at(500), bytes("state"));
  hub.deliver(kWind, at(500), bytes("old"));
  hub.deliver(kPicture, at(500), bytes("picture"));
  viewer.client->on_text("nonsense");
  hub.forget();
  hub.deliver(kWind, at(3), bytes("new"));
  EXPECT_EQ(hub.history(kWind)->size(), 4U + 13 + 3);
  EXPECT_EQ(hub.history(kStateChannel)->size(), 4U + 13 + 5) << "the display's own state is of now";
  const auto messages = viewer.read();
  ASSERT_EQ(messages.size(), 2U) << "what waited to be sent is forgotten too, but not what is no sample";
  EXPECT_TRUE(messages[0].is_text);
  EXPECT_EQ(text_of(messages[1].payload), "new");
}

class ReplayHubTest : public HubTest {
 protected:
  static bool is_playback(const OutMessage& message) { return !message.is_text && message.head.front() == '\x05'; }
  static std::vector<std::string> playback(Viewer& viewer) {
    std::vector<std::string> states;
    for (const auto& message : viewer.read()) {
      if (is_playback(message)) states.push_back(message.head);
    }
    return states;
  }
  PlaybackState now{.status = PlaybackStatus::paused, .time = at(4), .speed = 2};
  std::vector<PlaybackControl> asked;
  Demand replay_demand;
  Hub replay_hub{[] { return ServerInfo{.name = "roseau", .session_id = "s"}; },
                 {},
                 2000,
                 replay_demand,
                 {.state = [this] { return now; },
                  .control =
                      [this](const PlaybackControl& control) {
                        asked.push_back(control);
                        now.did_seek = control.seek.has_value();
                        return now;
                      }}};
  // Pause, speed 2, seek to 7 ns, "id".
  const std::string request = std::string("\x03\x01\0\0\0\x40\x01\x07\0\0\0\0\0\0\0\x02\0\0\0id", 21);
};

TEST_F(ReplayHubTest, AnswersWhoAskedAndTellsTheOthers) {
  Viewer asking(replay_hub);
  Viewer other(replay_hub);
  EXPECT_EQ(playback(asking).size(), 1U) << "a new viewer knows at once how it stands";
  playback(other);
  asking.client->on_binary(request);
  ASSERT_EQ(asked.size(), 1U);
  EXPECT_EQ(asked[0].seek, host_time_from_ns(7));
  now.request_id = "id";
  EXPECT_EQ(playback(asking), std::vector<std::string>{playback_state_message(now)});
  now.request_id.clear();
  EXPECT_EQ(playback(other), std::vector<std::string>{playback_state_message(now)});
}

TEST_F(ReplayHubTest, OlderViewersAreToldOnceTheyAsk) {
  Viewer older(replay_hub, kWebSocketSubprotocol);
  replay_hub.send_playback_state(now);
  EXPECT_TRUE(playback(older).empty()) << "it may not know this message";
  older.client->on_binary(request);
  EXPECT_EQ(playback(older).size(), 1U);
  replay_hub.send_playback_state(now);
  EXPECT_EQ(playback(older).size(), 1U);
}

TEST_F(ReplayHubTest, WrongRequestsAreAnsweredWithWords) {
  Viewer viewer(replay_hub);
  viewer.read();
  viewer.client->on_binary(request.substr(0, 12));
  const auto texts = viewer.read_texts();
  ASSERT_EQ(texts.size(), 1U);
  EXPECT_EQ(texts[0]["op"], "status");
  EXPECT_EQ(texts[0]["level"], 2);
  EXPECT_TRUE(asked.empty());

  Viewer live(hub);
  live.read();
  live.client->on_binary(request);
  const auto answers = live.read_texts();
  ASSERT_EQ(answers.size(), 1U);
  EXPECT_EQ(answers[0]["level"], 1);
}

TEST_F(HubTest, OnlyTheNewestPictureWaits) {
  Viewer viewer(hub);
  viewer.subscribe(1, kPicture);
  viewer.subscribe(2, kWind);
  viewer.read();
  for (int i = 0; i < 20; ++i) {
    hub.deliver(kPicture, at(i), bytes("picture" + std::to_string(i)));
    hub.deliver(kWind, at(i), bytes("w"));
  }
  const auto messages = viewer.read();
  ASSERT_EQ(messages.size(), 21U);  // every wind record, then one picture
  EXPECT_EQ(text_of(messages.back().payload), "picture19");
  EXPECT_EQ(hub.counters().images_dropped, 19U);
}

TEST_F(HubTest, CountsPicturesOfViewersThatHaveGone) {
  {
    Viewer viewer(hub);
    viewer.subscribe(1, kPicture);
    for (int i = 0; i < 3; ++i) hub.deliver(kPicture, at(i), bytes("p"));
  }
  EXPECT_EQ(hub.counters().clients, 0U);
  EXPECT_EQ(hub.counters().images_dropped, 2U);
}

TEST_F(HubTest, LetsAViewerGoWhoseMessagesPileUp) {
  Viewer slow(hub);
  Viewer quick(hub);
  slow.subscribe(1, kWind);
  quick.subscribe(1, kWind);
  slow.read();
  for (int i = 0; i < 100; ++i) {
    hub.deliver(kWind, at(i), bytes(std::string(100, 'w')));
    EXPECT_LE(quick.read().size(), 3U);
  }
  EXPECT_THAT(slow.link.closed, testing::HasSubstr("too slow"));
  EXPECT_EQ(quick.link.closed, "");
  EXPECT_EQ(hub.counters().slow_clients, 1U);
  // What it had been promised before still comes in order; nothing is added after the hole.
  EXPECT_LE(slow.read().size(), 20U);
}

TEST_F(HubTest, TellsWhetherAnybodyWatches) {
  EXPECT_FALSE(demand.wanted(kPicture));
  {
    Viewer first(hub);
    Viewer second(hub);
    first.subscribe(1, kPicture);
    second.subscribe(5, kPicture);
    EXPECT_TRUE(demand.wanted(kPicture));
    first.client->on_text(R"({"op":"unsubscribe","subscriptionIds":[1]})");
    EXPECT_TRUE(demand.wanted(kPicture));
  }
  EXPECT_FALSE(demand.wanted(kPicture));
}

TEST_F(HubTest, AdvertisesNewStreamsToViewersThatAreThere) {
  Viewer viewer(hub);
  viewer.read();
  hub.add_channels({{.channel = {.id = 99, .topic = "/camera0/target/branch/displacement"}}});
  const auto texts = viewer.read_texts();
  ASSERT_EQ(texts.size(), 1U);
  EXPECT_EQ(texts[0]["op"], "advertise");
  EXPECT_EQ(texts[0]["channels"].size(), 1U);
  EXPECT_GT(viewer.link.wakes, 0);
}

TEST_F(HubTest, AnswersNonsenseWithAStatusAndGoesOn) {
  Viewer viewer(hub);
  viewer.read();
  viewer.client->on_text("nonsense");
  viewer.client->on_binary(std::string_view("\x01\x02", 2));
  viewer.client->on_text(R"({"op":"unsubscribe","subscriptionIds":[9]})");
  viewer.subscribe(1, 424242);
  viewer.subscribe(1, kWind);
  viewer.subscribe(1, kWind);
  const auto texts = viewer.read_texts();
  ASSERT_EQ(texts.size(), 5U);
  for (const json& text : texts) EXPECT_EQ(text["op"], "status");
  hub.deliver(kWind, at(1), bytes("w"));
  EXPECT_EQ(viewer.read().size(), 1U);
}

TEST_F(HubTest, TellsItsParameters) {
  Viewer viewer(hub);
  viewer.read();
  viewer.client->on_text(R"({"op":"getParameters","parameterNames":[],"id":"all"})");
  viewer.client->on_text(R"({"op":"getParameters","parameterNames":["mode","unknown"]})");
  const auto texts = viewer.read_texts();
  ASSERT_EQ(texts.size(), 2U);
  EXPECT_EQ(texts[0]["parameters"].size(), 2U);
  EXPECT_EQ(texts[0]["id"], "all");
  EXPECT_EQ(texts[1]["parameters"][0]["value"], "live");
  EXPECT_FALSE(texts[1].contains("id"));
}

}  // namespace
}  // namespace roseau::display
