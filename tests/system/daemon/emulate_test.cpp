// One program plays the instruments of a scene, another one captures from them: as in the field, but for the cables.

#include <gmock/gmock.h>

#include <csignal>

#include "tests/system/daemon/program.h"

namespace roseau::testing {
namespace {

using ::testing::HasSubstr;

class EmulateTest : public ProgramTest {};

TEST_F(EmulateTest, TheDaemonCapturesFromEveryInstrument) {
  const std::string scene = folder_.write("empty.toml", "");
  Process emulator(command({"emulate", scene, "--sonic", "pty:" + path("sonic"), "--tracker", "pty:" + path("tracker"),
                            "--led-board", "pty:" + path("board"), "--for", "60", "--json"}),
                   folder_.path());
  ASSERT_TRUE(emulator.wait_for_err("led_board: ")) << emulator.err();
  folder_.write("field.toml",
                "[[sonic]]\nname = 'sonic'\nmodel = 'gill_windmaster'\nrate_hz = 20\nport = 'serial:" + path("sonic") +
                    "?baud=38400'\n"
                    "[[magnetic_tracker]]\nname = 'tracker'\nmodel = 'polhemus_fastrak'\nport = 'serial:" +
                    path("tracker") +
                    "?baud=115200'\n"
                    "[[led_board]]\nname = 'led_board'\nport = 'serial:" +
                    path("board") + "?baud=115200'\n");
  const auto captured = run({"run", path("field.toml"), "--headless", "--record", path("rec"), "--for", "4", "--json"});
  ASSERT_EQ(captured.status, 0) << captured.err;
  const auto streams = captured.json()["streams"];
  for (const char* topic : {"/sonic/raw", "/tracker/raw", "/led_board/raw"}) {
    ASSERT_TRUE(streams.contains(topic)) << captured.out;
    EXPECT_EQ(streams[topic]["bad"], 0) << topic;
    EXPECT_EQ(streams[topic]["dropped"], 0) << topic;
  }
  EXPECT_GT(streams["/sonic/raw"]["received"].get<int>(), 40);
  EXPECT_GT(streams["/tracker/raw"]["received"].get<int>(), 100);
  EXPECT_GT(streams["/led_board/raw"]["received"].get<int>(), 15);
  EXPECT_TRUE(captured.json()["clocks"].contains("led_board")) << captured.out;

  emulator.signal(SIGINT);
  EXPECT_EQ(emulator.wait(), 0);
  const auto played = nlohmann::json::parse(emulator.out());
  EXPECT_GT(played["tracker"]["bytes_received"].get<int>(), 40) << "the driver has set it up";
}

TEST_F(EmulateTest, WithoutLinksEachInstrumentGetsATerminal) {
  const auto played = run({"emulate", folder_.write("empty.toml", ""), "--for", "0.5"});
  EXPECT_EQ(played.status, 0);
  for (const char* name : {"sonic: pseudo terminal", "tracker: pseudo terminal", "led_board: pseudo terminal"}) {
    EXPECT_THAT(played.err, HasSubstr(name));
  }
}

TEST_F(EmulateTest, BadLinksAreNamed) {
  const auto bad = run({"emulate", "--sonic", "serail:/dev/null"});
  EXPECT_EQ(bad.status, 1);
  EXPECT_THAT(bad.err, HasSubstr("--sonic: link 'serail:/dev/null'"));
}

}  // namespace
}  // namespace roseau::testing
