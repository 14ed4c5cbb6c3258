// The promise everything rests on: the same inputs give the same results, whatever the speed.

#include <gmock/gmock.h>

#include <csignal>
#include <filesystem>
#include <fstream>
#include <thread>

#include "tests/system/daemon/program.h"

namespace roseau::testing {
namespace {

using ::testing::HasSubstr;

class ReplayTest : public ProgramTest {
 protected:
  std::string recording() const { return session_in(folder_.path() / "rec"); }
};

TEST_F(ReplayTest, DigestIsTheSameAtEverySpeed) {
  const auto session = simulate("s.mcap", "8");
  const auto fast = run({"replay", session, "--max", "--headless", "--json"}).json();
  const auto again = run({"replay", session, "--max", "--headless", "--json"}).json();
  const auto four = run({"replay", session, "--speed", "4", "--headless", "--json"}).json();
  const auto real = run({"replay", session, "--speed", "1", "--headless", "--json"}).json();
  EXPECT_EQ(fast["digest"], again["digest"]);
  EXPECT_EQ(fast["digest"], four["digest"]);
  EXPECT_EQ(fast["digest"], real["digest"]);
  EXPECT_EQ(fast["digest"].get<std::string>().size(), 64U);
  const auto frames = fast["streams"]["/camera0/image"]["received"].get<int>();
  EXPECT_GT(frames, 235);
  EXPECT_EQ(fast["streams"]["/camera0/target/branch/displacement"]["received"], frames) << "one result per frame";
  EXPECT_EQ(fast["streams"]["/camera0/image"]["dropped"], 0);
  // The leaves that the tracker sees move against the others: their mean is not the mean of all.
  EXPECT_LT(fast["truth"]["displacement_x/camera0/branch"]["rms"].get<double>(), 1.5);
  EXPECT_EQ(fast["truth"]["clock/camera0"]["max"], 0) << "these cameras are stamped by the host";
  EXPECT_LT(fast["truth"]["clock/sonic"]["rms"].get<double>(), 0.003);
}

TEST_F(ReplayTest, SimulationIsTheSameEachTime) {
  const auto digest = [this](const std::string& file) {
    return run({"replay", file, "--max", "--headless", "--json"}).json()["digest"];
  };
  const auto a = simulate("a.mcap", "2");
  const auto b = simulate("b.mcap", "2");
  EXPECT_EQ(digest(a), digest(b));
  const auto bytes = [](const std::string& file) {
    std::ifstream in(file, std::ios::binary);
    return std::string(std::istreambuf_iterator<char>(in), {});
  };
  EXPECT_TRUE(bytes(a) == bytes(b)) << "the files differ";
}

TEST_F(ReplayTest, LiveRunReplaysToTheSameResults) {
  const auto live = run({"run", live_config(), "--headless", "--record", path("rec"), "--for", "5", "--json"});
  ASSERT_EQ(live.status, 0) << live.err;
  const auto replayed = run({"replay", recording(), "--max", "--headless", "--json"});
  EXPECT_EQ(live.json()["digest"], replayed.json()["digest"]);
}

TEST_F(ReplayTest, ARecordedReplayHoldsTheSameInputs) {
  const auto session = simulate("s.mcap", "3");
  const auto first = run({"replay", session, "--max", "--headless", "--json", "--record", path("rec")}).json();
  const auto second = run({"replay", recording(), "--max", "--headless", "--json"}).json();
  EXPECT_EQ(first["digest"], second["digest"]);
}

TEST_F(ReplayTest, KilledWhileRecordingEverythingUpToTheLastSecondReads) {
  Process process(command({"run", live_config(), "--headless", "--record", path("rec")}), folder_.path());
  ASSERT_TRUE(process.wait_for_err("recording to"));
  std::this_thread::sleep_for(std::chrono::seconds(4));
  process.signal(SIGKILL);
  EXPECT_EQ(process.wait(), -SIGKILL);

  const auto info = run({"info", recording(), "--json"});
  ASSERT_EQ(info.status, 0) << info.err;
  const auto report = info.json();
  EXPECT_FALSE(report["complete"]);
  EXPECT_GT(report["duration_s"].get<double>(), 2.0) << "of the 4 s before the kill";
  EXPECT_GT(report["streams"]["/camera0/image"]["messages"], 60);
  EXPECT_TRUE(report["streams"]["/camera0/image"].contains("counters")) << "a checkpoint says what was received";
  const auto replayed = run({"replay", recording(), "--max", "--headless", "--json"});
  EXPECT_EQ(replayed.status, 0) << replayed.err;
  EXPECT_EQ(replayed.json()["streams"]["/camera0/image"]["received"], report["streams"]["/camera0/image"]["messages"]);
}

TEST_F(ReplayTest, CtrlCLeavesAWholeFile) {
  Process process(command({"run", live_config(), "--headless", "--record", path("rec")}), folder_.path());
  ASSERT_TRUE(process.wait_for_err("recording to"));
  std::this_thread::sleep_for(std::chrono::seconds(1));
  process.signal(SIGINT);
  EXPECT_EQ(process.wait(), 0) << process.err();
  const auto verified = run({"verify", recording(), "--json"});
  EXPECT_EQ(verified.status, 0) << verified.out;
  EXPECT_TRUE(verified.json()["whole"]);
}

TEST_F(ReplayTest, TruncatedSessionPlaysAsFarAsItReads) {
  const auto session = simulate("s.mcap", "3");
  std::filesystem::resize_file(session, std::filesystem::file_size(session) * 6 / 10);
  const auto ran = run({"replay", session, "--max", "--headless", "--json"});
  EXPECT_EQ(ran.status, 0) << ran.err;
  EXPECT_GT(ran.json()["streams"]["/camera0/image"]["received"], 20);
  EXPECT_EQ(run({"verify", session}).status, 1);
}

TEST_F(ReplayTest, OneBrokenByteIsFoundByVerifyAndSurvivedByReplay) {
  const auto session = simulate("s.mcap", "3");
  {
    std::fstream file(session, std::ios::in | std::ios::out | std::ios::binary);
    file.seekp(static_cast<std::streamoff>(std::filesystem::file_size(session) / 2));
    file.put('\x5a');
  }
  const auto verified = run({"verify", session, "--json"});
  EXPECT_EQ(verified.status, 1);
  EXPECT_GE(verified.json()["problem_count"], 1);
  const auto ran = run({"replay", session, "--max", "--headless", "--json"});
  EXPECT_EQ(ran.status, 0) << ran.err;
  EXPECT_THAT(ran.err, HasSubstr("going on behind it"));
}

}  // namespace
}  // namespace roseau::testing
