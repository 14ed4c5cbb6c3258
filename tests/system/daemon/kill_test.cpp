// The program killed at a random moment while it records: every sample older than a second is in the file, and its counts are
// honest. A few times here; as often as ROSEAU_KILLS says.

#include <gtest/gtest.h>

#include <chrono>
#include <cstdlib>
#include <random>
#include <thread>

#include "tests/support/session_facts.h"
#include "tests/system/daemon/program.h"

namespace roseau::testing {
namespace {

constexpr double kMayBeLost_s = 1;

class KillTest : public ProgramTest {
 protected:
  struct Killed {
    std::filesystem::path session;
    double at_s = 0;  // host monotonic time, as the session's log times
  };
  Killed record_and_kill(double after_s, const std::string& folder) const {
    Process process(command({"run", live_config(), "--headless", "--record", path(folder)}), folder_.path());
    EXPECT_TRUE(process.wait_for_err("recording to")) << process.err();
    std::this_thread::sleep_for(std::chrono::duration<double>(after_s));
    Killed killed;
    killed.at_s = std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
    process.signal(SIGKILL);
    EXPECT_EQ(process.wait(), -SIGKILL);
    killed.session = session_in(path(folder));
    return killed;
  }

  static void expect_nothing_old_is_lost(const SessionFacts& facts, double killed_at_s) {
    for (const char* topic : {"/camera0/image", "/camera1/image", "/sonic/raw"}) {
      const auto found = facts.streams.find(topic);
      ASSERT_NE(found, facts.streams.end()) << topic;
      EXPECT_EQ(found->second.missing, 0U) << topic;
      EXPECT_LE(killed_at_s - to_seconds(found->second.last_log_time.time_since_epoch()), kMayBeLost_s) << topic;
    }
  }

  /// The last checkpoint claims no more than there is; and what was received and is not there is said to be lost, or came after
  /// the checkpoint.
  static void expect_honest_counters(const SessionFacts& facts) {
    ASSERT_TRUE(facts.counters);
    for (const auto& [topic, counters] : *facts.counters) {
      const auto found = facts.streams.find(topic);
      const std::uint64_t messages = found == facts.streams.end() ? 0 : found->second.messages;
      EXPECT_LE(counters.recorded, messages) << topic;
    }
    EXPECT_GT(facts.counters->at("/camera0/image").recorded, 0U);
  }

  void expect_recoverable(const SessionFacts& facts, const std::filesystem::path& session, const std::string& name) const {
    const auto recovered = run({"recover", session.string(), "-o", path(name)});
    ASSERT_EQ(recovered.status, 0) << recovered.err;
    EXPECT_EQ(run({"verify", path(name)}).status, 0);
    const auto whole = read_session_facts(path(name));
    EXPECT_TRUE(whole.complete);
    for (const auto& [topic, stream] : facts.streams) EXPECT_GE(whole.streams.at(topic).messages, stream.messages) << topic;
  }
};

TEST_F(KillTest, EverythingOlderThanASecondIsThereAndCountsAreHonest) {
  const auto number = [](const char* variable, int otherwise) {
    const char* const set = std::getenv(variable);
    return set != nullptr ? std::atoi(set) : otherwise;
  };
  const int kills = number("ROSEAU_KILLS", 4);
  std::mt19937 random(static_cast<std::uint32_t>(number("ROSEAU_KILLS_SEED", 1)));
  std::uniform_real_distribution<double> after_s(1.3, 3);  // the first checkpoint comes after a second
  double worst_s = 0;
  for (int i = 0; i < kills; ++i) {
    SCOPED_TRACE("kill " + std::to_string(i));
    const std::string name = "killed" + std::to_string(i);
    const auto killed = record_and_kill(after_s(random), name);
    const auto facts = read_session_facts(killed.session);
    EXPECT_FALSE(facts.complete);
    expect_nothing_old_is_lost(facts, killed.at_s);
    expect_honest_counters(facts);
    expect_recoverable(facts, killed.session, name + ".mcap");
    worst_s = std::max(worst_s, killed.at_s - to_seconds(facts.last_log_time.time_since_epoch()));
    std::filesystem::remove_all(path(name));
    std::filesystem::remove(path(name + ".mcap"));
  }
  std::printf("%d kills, at most %.2f s lost\n", kills, worst_s);
}

}  // namespace
}  // namespace roseau::testing
