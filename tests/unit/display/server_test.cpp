#include "display/server.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <thread>

#include "display/channels.h"
#include "schema/conversion.h"
#include "tests/support/temporary_folder.h"
#include "tests/unit/display/loopback_client.h"

namespace roseau::display {
namespace {

using nlohmann::json;
using ::testing::HasSubstr;
using testing::LoopbackClient;
using ::testing::StartsWith;
using namespace std::chrono_literals;

constexpr const char* kJson = "Content-Type: application/json\r\n";

class FakePlayer final : public PlayerControl {
 public:
  void play() override { playing = true; }
  void pause() override { playing = false; }
  void set_speed(double value) override { speed = value; }
  void seek(HostTime time) override {
    position_ns = to_ns(time);
    ++jumps;
  }
  PlayerState state() const override {
    return {.playing = playing,
            .speed = speed,
            .position = host_time_from_ns(position_ns),
            .end = HostTime(100s),
            .jumps = jumps,
            .jumps_done = jumps_done};
  }
  std::atomic<std::uint64_t> jumps{0};
  std::atomic<std::uint64_t> jumps_done{0};
  std::atomic<std::int64_t> position_ns{7};
  std::atomic<bool> playing{true};
  std::atomic<double> speed{1};
};

class ServerTest : public ::testing::Test {
 protected:
  ServerTest() {
    web.write("index.html", "<title>roseau</title>");
    wind = streams.add({"/sonic/wind", "wind", StreamRole::derived, "sonic", {}});
    image = streams.add({"/camera0/image", "frame", StreamRole::raw, "camera0", {}});
  }

  std::uint16_t start(PlayerControl* replayed = nullptr) {
    DisplayOptions options{.port = 0, .web_root = web.path(), .session_name = "storm"};
    options.client_budget_bytes = budget_bytes;
    options.marks = marks;
    server = std::make_unique<DisplayServer>(
        options, streams, DisplayCallbacks{[this](const OperatorAction& action) { return on_action(action); }}, replayed);
    const auto port = server->start();
    EXPECT_TRUE(port) << port.error().message;
    return *port;
  }

  Result<void> on_action(const OperatorAction& action) {
    actions.push_back(action);
    if (action.camera == "camera9") return Error{ErrorCode::not_found, "there is no camera9"};
    return {};
  }

  /// Connected, and subscribed to `channel` as 1.
  std::unique_ptr<LoopbackClient> viewer(std::uint16_t port, ChannelId channel, int receive_buffer_bytes = 0) {
    auto client = std::make_unique<LoopbackClient>(port, receive_buffer_bytes);
    EXPECT_EQ(client->upgrade("foxglove.sdk.v1").status, 101);
    const std::string topic = channel == channel_of(wind) ? "/sonic/wind" : "/camera0/image";
    client->read_text_with(topic);
    client->send_text(json({{"op", "subscribe"}, {"subscriptions", {{{"id", 1}, {"channelId", channel}}}}}).dump());
    // Requests are answered in order: when this one is, the subscription stands.
    client->send_text(R"({"op":"getParameters","parameterNames":[],"id":"ready"})");
    client->read_text_with("ready");
    return client;
  }

  Sample wind_sample(std::uint32_t sequence) const {
    Sample sample;
    sample.header = {.stream = wind, .sequence = sequence, .arrival_time = host_time_from_ns(1'000'000 + sequence)};
    sample.payload = WindSample{.u_mps = 1.5 * sequence, .v_mps = -2};
    return sample;
  }

  Sample frame_sample(std::uint32_t sequence) {
    Sample sample;
    sample.header = {.stream = image, .sequence = sequence, .arrival_time = host_time_from_ns(sequence)};
    sample.payload = Frame{.pixels = pool.acquire(), .width = 1280, .height = 1024, .stride = 1280};
    return sample;
  }

  roseau::testing::TemporaryFolder web;
  StreamTable streams;
  StreamId wind = 0;
  StreamId image = 0;
  FramePool pool{8, 1280 * 1024};
  std::size_t budget_bytes = 1 << 20;
  FakePlayer player;
  std::vector<RecordedMark> marks;
  std::vector<OperatorAction> actions;  // written in the server's thread, read after its answer
  std::unique_ptr<DisplayServer> server;
};

TEST_F(ServerTest, SaysWhichPortIsInUseAndWhatToDo) {
  const std::uint16_t port = start();
  DisplayServer second({.port = port, .web_root = web.path()}, streams, {});
  const auto result = second.start();
  ASSERT_FALSE(result);
  EXPECT_EQ(result.error().code, ErrorCode::busy);
  EXPECT_THAT(result.error().message, HasSubstr(std::to_string(port)));
  EXPECT_THAT(result.error().message, HasSubstr("--port"));
}

TEST_F(ServerTest, RefusesAnAddressThatIsNone) {
  DisplayServer wrong({.address = "localhost", .port = 0, .web_root = web.path()}, streams, {});
  const auto result = wrong.start();
  ASSERT_FALSE(result);
  EXPECT_THAT(result.error().message, HasSubstr("127.0.0.1"));
}

TEST_F(ServerTest, ServesThePageWithATag) {
  LoopbackClient client(start());
  const auto page = client.request("GET", "/");
  EXPECT_EQ(page.status, 200);
  EXPECT_EQ(page.body, "<title>roseau</title>");
  EXPECT_THAT(page.header("Content-Type"), StartsWith("text/html"));
  EXPECT_THAT(page.header("Content-Security-Policy"), HasSubstr("default-src 'self'"));
  // The same connection serves on.
  EXPECT_EQ(client.request("GET", "/", "If-None-Match: " + page.header("ETag") + "\r\n").status, 304);
  EXPECT_EQ(client.request("HEAD", "/").header("Content-Length"), "21");
  EXPECT_EQ(client.request("GET", "/nothing").status, 404);
  EXPECT_EQ(client.request("DELETE", "/").status, 405);
}

TEST_F(ServerTest, ServesTheProtocolWithoutThePage) {
  DisplayServer bare({.port = 0, .web_root = web.path() / "absent"}, streams, {});
  const auto port = bare.start();
  ASSERT_TRUE(port);
  LoopbackClient client(*port);
  EXPECT_THAT(client.request("GET", "/").body, HasSubstr("./dev build"));
  EXPECT_EQ(client.upgrade("foxglove.websocket.v1").status, 101);
}

TEST_F(ServerTest, EchoesTheSubprotocolOrRefuses) {
  const std::uint16_t port = start();
  for (const char* name : {"foxglove.sdk.v1", "foxglove.websocket.v1"}) {
    LoopbackClient client(port);
    const auto answer = client.upgrade(name);
    EXPECT_EQ(answer.status, 101);
    EXPECT_EQ(answer.header("Sec-WebSocket-Protocol"), name);
    EXPECT_THAT(client.read_message()->payload, HasSubstr("serverInfo"));
  }
  LoopbackClient foreign(port);
  EXPECT_EQ(foreign.upgrade("mqtt").status, 400);
  LoopbackClient none(port);
  EXPECT_EQ(none.upgrade("").status, 400);
}

TEST_F(ServerTest, KeepsForeignSitesAway) {
  const std::uint16_t port = start();
  const std::string mark = R"({"kind":"mark"})";
  const auto post = [&](const std::string& headers) {
    LoopbackClient client(port);
    return client.request("POST", "/api/action", headers, mark).status;
  };
  EXPECT_EQ(post(std::string(kJson) + "Origin: https://evil.example\r\n"), 403);
  EXPECT_EQ(post(std::string(kJson) + "Host: evil.example:8420\r\n"), 403);
  EXPECT_EQ(post("Content-Type: text/plain\r\n"), 415);
  EXPECT_TRUE(actions.empty());
  LoopbackClient viewer(port);
  EXPECT_EQ(viewer.upgrade("foxglove.sdk.v1", "Origin: https://evil.example\r\n").status, 403);
  LoopbackClient rebound(port);
  EXPECT_EQ(rebound.upgrade("foxglove.sdk.v1", "Host: evil.example\r\nOrigin: http://evil.example\r\n").status, 403);
  EXPECT_EQ(post(std::string(kJson) + "Origin: http://127.0.0.1:" + std::to_string(port) + "\r\n"), 200);
  EXPECT_EQ(actions.size(), 1U);
}

TEST_F(ServerTest, HandsActionsOnAndTellsWhatWentWrong) {
  LoopbackClient client(start());
  EXPECT_EQ(client.request("POST", "/api/action", kJson, R"({"kind":"mark","text":"gust"})").status, 200);
  ASSERT_EQ(actions.size(), 1U);
  EXPECT_EQ(actions[0].text, "gust");
  const auto refused =
      client.request("POST", "/api/action", kJson,
                     R"({"kind":"add_target","text":"a","camera":"camera9","region":{"x":1,"y":1,"width":9,"height":9}})");
  EXPECT_EQ(refused.status, 409);
  EXPECT_EQ(json::parse(refused.body)["error"], "there is no camera9");
  EXPECT_EQ(client.request("POST", "/api/action", kJson, "nonsense").status, 400);
  EXPECT_EQ(client.request("POST", "/api/player", kJson, R"({"command":"pause"})").status, 409);
  EXPECT_EQ(client.request("POST", "/api/other", kJson, "{}").status, 404);
}

TEST_F(ServerTest, RefusesABodyThatIsTooLarge) {
  LoopbackClient client(start());
  EXPECT_EQ(client.request("POST", "/api/action", kJson, std::string(100'000, 'x')).status, 413);
}

/// Pause at speed 2, seek to `time_ns`, "r1".
std::string control_request(std::uint64_t time_ns) {
  std::string bytes("\x03\x01\0\0\0\x40\x01", 7);
  for (int shift = 0; shift < 64; shift += 8) bytes.push_back(static_cast<char>((time_ns >> shift) & 0xff));
  return bytes + std::string("\x02\0\0\0r1", 6);
}

/// The next binary message that begins with `opcode`; others are passed over.
std::string read_binary_with(LoopbackClient& client, char opcode) {
  // The time comes twenty times a second whatever else does: after ten seconds nothing more is expected.
  for (int i = 0; i < 250; ++i) {
    const auto message = client.read_message();
    if (message && message->opcode == 2 && message->payload.front() == opcode) return message->payload;
  }
  ADD_FAILURE() << "no binary message with opcode " << int{opcode};
  return std::string(64, '\0');
}

TEST_F(ServerTest, AViewerDrivesTheReplayAndIsToldSo) {
  const auto client = viewer(start(&player), channel_of(wind));
  client->send_frame(2, control_request(9'000));
  std::string told;
  do {
    told = read_binary_with(*client, '\x05');
  } while (!told.ends_with("r1"));
  EXPECT_EQ(told, std::string("\x05\x01\x28\x23\0\0\0\0\0\0\0\0\0\x40\x01\x02\0\0\0r1", 21)) << "paused at 9000 ns, speed 2";
  EXPECT_FALSE(player.playing);
  EXPECT_DOUBLE_EQ(player.speed, 2);
  EXPECT_EQ(player.position_ns, 9'000);
  // It goes on telling, to nobody in particular and of no seek.
  told = read_binary_with(*client, '\x05');
  EXPECT_EQ(told.substr(14), std::string("\0\0\0\0\0", 5));
}

TEST_F(ServerTest, FromASeekOnNothingIsShownOfThePlaceBefore) {
  const std::uint16_t port = start(&player);
  const auto client = viewer(port, channel_of(wind));
  server->publish(wind_sample(1), host_time_from_ns(1));
  EXPECT_EQ(read_binary_with(*client, '\x01').substr(5, 1), "\x01");
  client->send_frame(2, control_request(9'000));
  while (!read_binary_with(*client, '\x05').ends_with("r1")) {
  }
  // The pipeline has not followed yet: what it still gives is of the place before.
  server->publish(wind_sample(2), host_time_from_ns(2));
  player.jumps_done = 1;
  server->restart();
  server->publish(wind_sample(3), host_time_from_ns(3));
  EXPECT_EQ(read_binary_with(*client, '\x01').substr(5, 1), "\x03");
  LoopbackClient other(port);
  const auto history = other.request("GET", "/api/history?channel=" + std::to_string(channel_of(wind))).body;
  ASSERT_GT(history.size(), 17U);
  EXPECT_EQ(history.substr(4 + 5, 1), "\x03") << "the first that is kept";
}

TEST_F(ServerTest, PagesLearnOfAJumpBeforeTheySeeTheNewPlace) {
  const auto client = viewer(start(&player), channel_of(wind));
  client->send_text(json({{"op", "subscribe"}, {"subscriptions", {{{"id", 2}, {"channelId", kStateChannel}}}}}).dump());
  read_binary_with(*client, '\x01');
  // A round of a loop: nobody asked for it.
  player.jumps = 1;
  player.jumps_done = 1;
  server->restart();
  server->publish(wind_sample(3), host_time_from_ns(3));
  bool knows = false;
  for (;;) {
    const auto message = read_binary_with(*client, '\x01');
    if (message[1] == 1) break;
    knows = knows || json::parse(message.substr(13))["player"]["jumps"] == 1;
  }
  EXPECT_TRUE(knows);
}

TEST_F(ServerTest, APausedReplayShowsItsPictureToWhoComesLater) {
  const std::uint16_t port = start(&player);
  server->publish(frame_sample(1), host_time_from_ns(1));
  for (int i = 0; i < 2; ++i) {
    LoopbackClient client(port);
    ASSERT_EQ(client.upgrade("foxglove.sdk.v1").status, 101);
    client.read_text_with("/camera0/image/preview");
    client.send_text(
        json({{"op", "subscribe"}, {"subscriptions", {{{"id", 1}, {"channelId", preview_channel_of(image)}}}}}).dump());
    EXPECT_EQ(read_binary_with(client, '\x01').substr(5, 1), "\x01") << "viewer " << i;
  }
}

TEST_F(ServerTest, TheLastPictureOfABurstIsShown) {
  const auto client = viewer(start(&player), preview_channel_of(image));
  for (std::uint32_t i = 1; i <= 5; ++i) {
    server->publish(frame_sample(i), host_time_from_ns(i));
    std::this_thread::sleep_for(2ms);
  }
  while (read_binary_with(*client, '\x01')[5] != '\x05') {
  }
}

TEST_F(ServerTest, ListsWhatWasMarkedWhenItWasRecorded) {
  marks = {{host_time_from_ns(5'000'000'007), "gust"}};
  LoopbackClient client(start(&player));
  const json list = json::parse(client.request("GET", "/api/marks").body)["marks"];
  ASSERT_EQ(list.size(), 1U);
  EXPECT_EQ(list[0]["time_ns"], "5000000007");
  EXPECT_EQ(list[0]["text"], "gust");
}

TEST_F(ServerTest, ObeysReplayControlsAndSendsTheTime) {
  const std::uint16_t port = start(&player);
  LoopbackClient client(port);
  EXPECT_EQ(client.request("POST", "/api/player", kJson, R"({"command":"pause"})").status, 200);
  EXPECT_EQ(client.request("POST", "/api/player", kJson, R"({"command":"speed","speed":4})").status, 200);
  EXPECT_FALSE(player.playing);
  EXPECT_DOUBLE_EQ(player.speed, 4);
  EXPECT_EQ(json::parse(client.request("GET", "/api/state").body)["player"]["playing"], false);
  const auto watcher = viewer(port, channel_of(wind));
  for (;;) {
    const auto message = watcher->read_message();
    ASSERT_TRUE(message);
    if (message->opcode != 2) continue;
    EXPECT_EQ(message->payload, std::string("\x02\x07\0\0\0\0\0\0\0", 9));
    break;
  }
}

TEST_F(ServerTest, DeliversSmallMessagesInOrderAndAll) {
  const auto client = viewer(start(), channel_of(wind));
  constexpr std::uint32_t kCount = 500;
  for (std::uint32_t i = 0; i < kCount; ++i) ASSERT_TRUE(server->receive(wind_sample(i)));
  for (std::uint32_t i = 0; i < kCount; ++i) {
    const auto message = client->read_message();
    ASSERT_TRUE(message);
    ASSERT_EQ(message->opcode, 2);
    EXPECT_EQ(message->payload.substr(0, 13), message_data_header(1, host_time_from_ns(1'000'000 + i)));
    const auto payload = std::as_bytes(std::span(message->payload)).subspan(13);
    const auto sample = schema::parse(SampleKind::wind, payload, {.stream = wind}, streams);
    ASSERT_TRUE(sample);
    EXPECT_DOUBLE_EQ(std::get<WindSample>(sample->payload).u_mps, 1.5 * i);
  }
  EXPECT_TRUE(server->dropped().empty());
}

TEST_F(ServerTest, SendsPreviewsAndRawPicturesToWhoAsks) {
  const std::uint16_t port = start();
  const auto preview = viewer(port, preview_channel_of(image));
  ASSERT_TRUE(server->receive(frame_sample(1)));
  const auto small = preview->read_message();
  ASSERT_TRUE(small);
  EXPECT_THAT(small->payload, HasSubstr("jpeg"));
  EXPECT_LT(small->payload.size(), 100'000U);
  const auto raw = viewer(port, channel_of(image));
  ASSERT_TRUE(server->receive(frame_sample(2)));
  const auto large = raw->read_message();
  ASSERT_TRUE(large);
  EXPECT_GT(large->payload.size(), 1280U * 1024U);
}

TEST_F(ServerTest, PicturesReplacedByNewerOnesAreNoLostMessages) {
  const std::uint16_t port = start();
  const auto watching = viewer(port, preview_channel_of(image));
  // Far more than can be shown: most are replaced before their turn.
  for (std::uint32_t i = 1; i <= 2000; ++i) {
    Sample sample = frame_sample(i);
    if (!std::get<Frame>(sample.payload).pixels) continue;
    ASSERT_TRUE(server->receive(std::move(sample)));
  }
  EXPECT_GT(server->dropped().at("/camera0/image"), 0U);
  LoopbackClient asking(port);
  EXPECT_EQ(json::parse(asking.request("GET", "/api/state").body)["messages_dropped"], 0);
}

TEST_F(ServerTest, TakesNoPictureThatNobodyWatches) {
  start();
  ASSERT_TRUE(server->receive(frame_sample(1)));
  EXPECT_EQ(pool.free_count(), 8U);
}

TEST_F(ServerTest, SurvivesNonsense) {
  const std::uint16_t port = start();
  {
    LoopbackClient client(port);
    client.send("\x16\x03\x01 this is no HTTP\r\n\r\n");
    EXPECT_EQ(client.read_answer().status, 400);
  }
  const auto client = viewer(port, channel_of(wind));
  client->send_text("nonsense");
  client->read_text_with("not a JSON object");
  client->send_frame(2, std::string("\xee\x01\x02", 3));
  client->read_text_with("unknown binary opcode 238");
  client->send_frame(1, std::string("\xff\xfe", 2));  // no UTF-8: the WebSocket protocol itself forbids it
  while (auto message = client->read_message()) {
    if (message->opcode == 8) break;
  }
  LoopbackClient torn(port);
  EXPECT_EQ(torn.upgrade("foxglove.sdk.v1").status, 101);
  torn.send("\xff\xff\xff\xff");
  LoopbackClient huge(port);
  EXPECT_EQ(huge.upgrade("foxglove.sdk.v1").status, 101);
  huge.send_text(std::string(400'000, 'x'));
  while (auto message = huge.read_message()) {
    if (message->opcode == 8) break;
  }
  LoopbackClient after(port);
  EXPECT_EQ(after.request("GET", "/").status, 200);
}

TEST_F(ServerTest, LetsAStalledViewerGoAndServesTheOthers) {
  budget_bytes = 64 * 1024;
  const std::uint16_t port = start();
  const auto stalled = viewer(port, channel_of(wind), /*receive_buffer_bytes=*/4096);
  const auto quick = viewer(port, channel_of(wind));
  std::uint32_t sent = 0;
  // The stalled one reads nothing: kernel buffers fill, then its budget, then it is let go.
  const auto slow_clients = [&] {
    LoopbackClient asking(port);
    return json::parse(asking.request("GET", "/api/state").body)["slow_clients"].get<int>();
  };
  std::uint32_t received = 0;
  while (slow_clients() == 0 && sent < 200'000) {
    for (int i = 0; i < 500; ++i) ASSERT_TRUE(server->receive(wind_sample(sent++)));
    while (received < sent) {
      ASSERT_TRUE(quick->read_message());
      ++received;
    }
  }
  EXPECT_EQ(slow_clients(), 1);
  EXPECT_EQ(received, sent);  // nobody else lost anything
}

TEST_F(ServerTest, ASlowViewerSeesTheNewestPictureNext) {
  const std::uint16_t port = start();
  const auto slow = viewer(port, channel_of(image), /*receive_buffer_bytes=*/4096);
  for (std::uint32_t i = 1; i <= 40; ++i) {
    ASSERT_TRUE(server->receive(frame_sample(i)));
    while (pool.free_count() < 6) std::this_thread::yield();
  }
  // Wait until the display has worked off what it was given.
  LoopbackClient asking(port);
  while (json::parse(asking.request("GET", "/api/state").body)["time_ns"] != "40") std::this_thread::yield();
  std::vector<std::uint32_t> seen;
  while (seen.empty() || seen.back() != 40) {
    const auto message = slow->read_message();
    ASSERT_TRUE(message);
    if (message->opcode != 2) continue;
    seen.push_back(static_cast<std::uint32_t>(static_cast<unsigned char>(message->payload[5])));
  }
  EXPECT_LE(seen.size(), 4U);  // the one under way, perhaps one more, and the newest
}

TEST_F(ServerTest, TellsNewStreamsWhileRunning) {
  const auto client = viewer(start(), channel_of(wind));
  streams.add({"/camera0/target/branch/displacement", "displacement", StreamRole::derived, "camera0", {}});
  client->read_text_with("/camera0/target/branch/displacement");
}

TEST_F(ServerTest, KeepsThePastForLaterViewers) {
  const std::uint16_t port = start();
  for (std::uint32_t i = 0; i < 10; ++i) ASSERT_TRUE(server->receive(wind_sample(i)));
  LoopbackClient client(port);
  const std::string target = "/api/history?channel=" + std::to_string(channel_of(wind));
  std::string history;
  while ((history = client.request("GET", target).body).size() < 10 * 20) std::this_thread::yield();
  EXPECT_EQ(history.substr(4, 13), message_data_header(0, host_time_from_ns(1'000'000)));
  EXPECT_EQ(client.request("GET", "/api/history?channel=70000").status, 404);
}

TEST_F(ServerTest, EndsWithViewersConnected) {
  const auto client = viewer(start(), channel_of(wind));
  server->stop();
  std::optional<testing::WsMessage> last;
  while (auto message = client->read_message()) last = message;
  ASSERT_TRUE(last);
  EXPECT_EQ(last->opcode, 8);
  EXPECT_THAT(last->payload, HasSubstr("closing"));
}

}  // namespace
}  // namespace roseau::display
