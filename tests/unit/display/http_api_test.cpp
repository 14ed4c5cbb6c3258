#include "display/http_api.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

namespace roseau::display {
namespace {

using nlohmann::json;
using namespace std::chrono_literals;

TEST(ParseAction, ReadsEveryKind) {
  const auto target = parse_action(
      R"({"kind":"add_target","text":"branch","camera":"camera0","region":{"x":10,"y":20.5,"width":30,"height":40}})");
  ASSERT_TRUE(target);
  EXPECT_EQ(target->kind, OperatorAction::Kind::add_target);
  EXPECT_EQ(target->text, "branch");
  EXPECT_EQ(target->camera, "camera0");
  EXPECT_DOUBLE_EQ(target->region.y, 20.5);
  EXPECT_EQ(parse_action(R"({"kind":"mark"})")->kind, OperatorAction::Kind::mark);
  EXPECT_EQ(parse_action(R"({"kind":"note","text":"gusts"})")->kind, OperatorAction::Kind::note);
  EXPECT_EQ(parse_action(R"({"kind":"remove_target","text":"a"})")->kind, OperatorAction::Kind::remove_target);
  EXPECT_EQ(parse_action(R"({"kind":"start_recording"})")->kind, OperatorAction::Kind::start_recording);
  EXPECT_EQ(parse_action(R"({"kind":"stop_recording"})")->kind, OperatorAction::Kind::stop_recording);
  EXPECT_EQ(parse_action(R"({"kind":"trigger"})")->kind, OperatorAction::Kind::trigger);
}

TEST(ParseAction, SaysWhatIsWrong) {
  const std::vector<std::pair<std::string, std::string>> cases = {
      {"", "no JSON object"},
      {"7", "no JSON object"},
      {"{}", "kind"},
      {R"({"kind":"explode"})", "kind"},
      {R"({"kind":5})", "kind"},
      {R"({"kind":"mark","text":5})", "text"},
      {R"({"kind":"note"})", "empty note"},
      {R"({"kind":"mark","text":")" + std::string(501, 'x') + "\"}", "500"},
      {R"({"kind":"add_target","text":"a","region":{"x":1,"y":1,"width":9,"height":9}})", "camera"},
      {R"({"kind":"add_target","text":"a","camera":"c"})", "region"},
      {R"({"kind":"add_target","text":"a","camera":"c","region":{"x":1,"y":1,"width":9}})", "height"},
      {R"({"kind":"add_target","text":"a","camera":"c","region":{"x":1,"y":1,"width":0,"height":9}})", "empty"},
      {R"({"kind":"add_target","text":"a","camera":"c","region":{"x":1e999,"y":1,"width":2,"height":9}})", ""},
      {R"({"kind":"remove_target"})", "name of the target"},
  };
  for (const auto& [body, words] : cases) {
    const auto action = parse_action(body);
    ASSERT_FALSE(action) << body;
    EXPECT_THAT(action.error().message, testing::HasSubstr(words)) << body;
  }
}

TEST(ParsePlayerCommand, ReadsCommandsAndRefusesTheRest) {
  EXPECT_EQ(parse_player_command(R"({"command":"pause"})")->kind, PlayerCommand::Kind::pause);
  EXPECT_EQ(parse_player_command(R"({"command":"play"})")->kind, PlayerCommand::Kind::play);
  EXPECT_DOUBLE_EQ(parse_player_command(R"({"command":"speed","speed":4})")->speed, 4);
  EXPECT_TRUE(std::isinf(parse_player_command(R"({"command":"speed","speed":null})")->speed));
  const auto seek = parse_player_command(R"({"command":"seek","time_s":12.5})");
  ASSERT_TRUE(seek);
  EXPECT_EQ(seek->kind, PlayerCommand::Kind::seek);
  EXPECT_DOUBLE_EQ(seek->time_s, 12.5);
  for (const char* body :
       {"", "{}", R"({"command":"jump"})", R"({"command":"seek"})", R"({"command":"seek","time_s":"1"})",
        R"({"command":"seek","time_s":1e999})", R"({"command":"speed"})", R"({"command":"speed","speed":0})",
        R"({"command":"speed","speed":-1})", R"({"command":"speed","speed":"2"})", R"({"command":"speed","speed":1e9})"}) {
    EXPECT_FALSE(parse_player_command(body)) << body;
  }
}

TEST(ApplyPlayerCommand, SeeksFromTheBeginAndStaysInTheSession) {
  class Recording final : public PlayerControl {
   public:
    void play() override {}
    void pause() override {}
    void set_speed(double) override {}
    void seek(HostTime time) override { sought = time; }
    PlayerState state() const override { return {.begin = HostTime(100s), .end = HostTime(160s)}; }
    HostTime sought;
  } player;
  const auto seek = [&player](double time_s) {
    apply({.kind = PlayerCommand::Kind::seek, .time_s = time_s}, player);
    return player.sought;
  };
  EXPECT_EQ(seek(12.5), HostTime(112500ms));
  EXPECT_EQ(seek(-3), HostTime(100s));
  EXPECT_EQ(seek(1e300), HostTime(160s));
}

TEST(StateJson, CarriesTimesAsTextAndTheFastestSpeedAsNull) {
  PlayerState player{.playing = false, .speed = std::numeric_limits<double>::infinity()};
  player.jumps = 3;
  player.position = host_time_from_ns(9'007'199'254'740'993);  // no double holds it
  const json state = json::parse(state_json({.newest = host_time_from_ns(9'007'199'254'740'993),
                                             .viewers = {.clients = 2, .images_dropped = 5},
                                             .pictures = {{"/camera0/image/preview", 1280, 1024}},
                                             .player = player}));
  EXPECT_EQ(state["time_ns"], "9007199254740993");
  EXPECT_EQ(state["player"]["position_ns"], "9007199254740993");
  EXPECT_TRUE(state["player"]["speed"].is_null());
  EXPECT_EQ(state["player"]["jumps"], 3);
  EXPECT_EQ(state["clients"], 2);
  EXPECT_EQ(state["pictures"][0]["width_px"], 1280);
  EXPECT_TRUE(json::parse(state_json({}))["player"].is_null());
}

TEST(StreamsJson, ListsEveryStreamWithItsChannel) {
  StreamTable streams;
  const StreamId id = streams.add({"/sonic/wind", "wind", StreamRole::derived, "sonic", {{"north_offset_deg", "235"}}});
  const json list = json::parse(streams_json(streams))["streams"];
  ASSERT_EQ(list.size(), 1U);
  EXPECT_EQ(list[0]["channel"], channel_of(id));
  EXPECT_EQ(list[0]["device"], "sonic");
  EXPECT_EQ(list[0]["role"], "derived");
  EXPECT_EQ(list[0]["metadata"]["north_offset_deg"], "235");
}

TEST(ChannelInQuery, TakesNumbersOnly) {
  EXPECT_EQ(channel_in_query("/api/history?channel=12"), 12U);
  for (const char* target : {"/api/history", "/api/history?channel=", "/api/history?channel=-1", "/api/history?channel=1x",
                             "/api/history?channel=99999999999"}) {
    EXPECT_FALSE(channel_in_query(target)) << target;
  }
}

}  // namespace
}  // namespace roseau::display
