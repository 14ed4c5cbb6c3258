// Recording control of the real program on the simulated rig: by triggers, by command and by signal.

#include <gmock/gmock.h>

#include <csignal>

#include "tests/system/daemon/program.h"

namespace roseau::testing {
namespace {

using ::testing::HasSubstr;

// The simulated tree's past is computed first: seconds of work, many of them on a busy machine.
constexpr std::chrono::seconds kPatience{200};

class RecordingControlTest : public ProgramTest {
 protected:
  std::string config(const std::string& recording) const {
    small_scene();
    return folder_.write(
        "live.toml", "name = 'rig'\n[simulation]\nscene = 'scene.toml'\n[recording]\ndirectory = 'recordings'\n" + recording);
  }
  std::vector<std::string> recordings() const {
    std::vector<std::string> files;
    std::error_code none;
    for (const auto& entry : std::filesystem::directory_iterator(folder_.path() / "recordings", none)) {
      files.push_back(entry.path().string());
    }
    return files;
  }
  void expect_whole(const std::string& file) const {
    const auto verified = run({"verify", file});
    EXPECT_EQ(verified.status, 0) << verified.out << verified.err;
  }
};

TEST_F(RecordingControlTest, WindOnTheSimulatedRigTriggersOnce) {
  const auto live = config(
      "pre_trigger_s = 1\npre_trigger_mib = 256\npost_trigger_s = 60\n"
      "[[recording.trigger]]\nname = 'any'\ntopic = '/sonic/wind'\nquantity = 'wind_speed_mps'\nabove = 0.01\nfor_s = 2\n");
  const auto ran = run({"run", live, "--headless", "--for", "6", "--json"});
  ASSERT_EQ(ran.status, 0) << ran.err;
  EXPECT_THAT(ran.err, HasSubstr("trigger any: wind_speed_mps"));
  ASSERT_EQ(recordings().size(), 1U);
  expect_whole(recordings().front());
  const auto streams = ran.json()["streams"];
  const auto received = streams["/sonic/wind"]["received"].get<int>();
  const auto recorded = streams["/sonic/wind"]["recorded"].get<int>();
  EXPECT_LT(recorded, received) << "the first second is older than the past that is kept";
  EXPECT_GT(recorded, received / 4);
  EXPECT_EQ(streams["/camera0/image"]["dropped"], 0);
  EXPECT_GT(streams["/camera0/image"]["recorded"].get<int>(), 0);
  // Inputs of the recording: the mark that says why, and the targets of both cameras, chosen before it began.
  const auto replayed = run({"replay", recordings().front(), "--max", "--headless", "--json"});
  ASSERT_EQ(replayed.status, 0) << replayed.err;
  EXPECT_EQ(replayed.json()["streams"]["/roseau/operator"]["received"], 3);
}

TEST_F(RecordingControlTest, StartsStopsAndTriggersByCommandAndSignal) {
  Process daemon(command({"run", config("post_trigger_s = 60\n"), "--port", "0"}), folder_.path());
  ASSERT_TRUE(daemon.wait_for_err("live page: http://127.0.0.1:", kPatience)) << daemon.err();
  const std::string said = daemon.err();
  const std::size_t at = said.find("http://127.0.0.1:") + 17;
  const std::string port = said.substr(at, said.find_first_not_of("0123456789", at) - at);
  const auto record = [&](const std::string& order) { return run({"record", order, "--port", port}); };

  const auto stopped = record("stop");
  EXPECT_EQ(stopped.status, 1);
  EXPECT_THAT(stopped.err, HasSubstr("nothing is being recorded"));
  EXPECT_EQ(record("start").status, 0);
  ASSERT_TRUE(daemon.wait_for_err("recording to ", kPatience)) << daemon.err();
  EXPECT_EQ(record("start").status, 1) << "already recording";
  EXPECT_EQ(record("trigger").status, 0);
  EXPECT_EQ(record("stop").status, 0);
  // The page's figures are renewed once a second.
  std::string phase;
  for (int i = 0; i < 200 && phase != "idle"; ++i) {
    const auto status = run({"record", "--json", "--port", port});
    if (status.status == 0) phase = status.json()["phase"];
  }
  EXPECT_EQ(phase, "idle");
  daemon.signal(SIGUSR1);
  for (int i = 0; i < 200 && phase != "post_trigger"; ++i) {
    const auto status = run({"record", "--json", "--port", port});
    if (status.status == 0) phase = status.json()["phase"];
  }
  EXPECT_EQ(phase, "post_trigger");
  EXPECT_THAT(record("status").out, HasSubstr("post_trigger (trigger signal), ends in"));
  daemon.signal(SIGTERM);
  EXPECT_EQ(daemon.wait(), 0) << daemon.err();
  ASSERT_EQ(recordings().size(), 2U);
  for (const auto& file : recordings()) expect_whole(file);
}

TEST_F(RecordingControlTest, AKilledRecorderGoesOnInTheNextPartAndEverythingIsCopied) {
  const auto live = config("at_start = true\nresume_after_crash = true\nsplit_s = 1\ncopy_directory = 'second'\n");
  Process killed(command({"run", live, "--headless"}), folder_.path());
  ASSERT_TRUE(killed.wait_for_err(".part002.mcap", kPatience)) << killed.err();
  killed.signal(SIGKILL);
  EXPECT_EQ(killed.wait(), -SIGKILL);
  const auto ran = run({"run", live, "--headless", "--for", "3"});
  ASSERT_EQ(ran.status, 0) << ran.err;
  EXPECT_THAT(ran.err, HasSubstr("going on with session rig-"));
  // Killed between the making of a file and its first byte there is nothing to mend.
  EXPECT_THAT(ran.err, ::testing::AnyOf(HasSubstr("is whole again"), HasSubstr("nothing was written")));
  const auto files = recordings();
  EXPECT_GE(files.size(), 4U);
  for (const auto& file : files) {
    if (file.ends_with(".torn")) continue;  // what could not be read
    EXPECT_THAT(file, ::testing::EndsWith(".mcap")) << "nothing else is left";
    expect_whole(file);
    EXPECT_EQ(read_text_file(folder_.path() / "second" / std::filesystem::path(file).filename()), read_text_file(file));
  }
}

TEST_F(RecordingControlTest, WhereNobodyListensTheCommandSaysSo) {
  const auto ran = run({"record", "--port", "1"});
  EXPECT_EQ(ran.status, 1);
  EXPECT_THAT(ran.err, HasSubstr("no roseau answers there"));
  EXPECT_EQ(run({"record", "pause"}).status, 2);
}

}  // namespace
}  // namespace roseau::testing
