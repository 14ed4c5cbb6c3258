// Power cuts: a machine stopped dead while it records to its own disk. What was older than two seconds must be there.

#include <gtest/gtest.h>

#include <cstdlib>
#include <random>
#include <thread>

#include "tests/hardware/recording_guest.h"
#include "tests/hardware/virtual_machine.h"
#include "tests/hardware/write_log.h"
#include "tests/support/session_facts.h"

namespace roseau::testing {
namespace {

constexpr double kMayBeLost_s = 2;
constexpr auto kBootLimit = std::chrono::seconds(120);
const char* const kMountDisk = "$MP virtio_blk && $MP ext4 && mount /dev/vda /tmp/disk || exit 3";

int times(const char* variable, int otherwise) {
  const char* const set = std::getenv(variable);
  return set != nullptr ? std::atoi(set) : otherwise;
}

class PowerCutTest : public ::testing::Test {
 protected:
  void SetUp() override { write_recording_guest(work_, kMountDisk, "", 100); }
  std::filesystem::path disk() const { return work_.path() / "disk.img"; }
  std::filesystem::path restored() const { return work_.path() / "restored"; }

  /// Nothing in the middle is missing, and `roseau recover` makes a whole session of it.
  SessionFacts expect_recoverable(const std::filesystem::path& session) const {
    const auto facts = read_session_facts(session);
    for (const auto& [topic, stream] : facts.streams) {
      EXPECT_TRUE(stream.role != StreamRole::raw || stream.missing == 0) << topic << ": " << stream.missing;
    }
    const auto whole = work_.path() / "whole.mcap";
    std::filesystem::remove(whole);
    Process recover({ROSEAU_PROGRAM, "recover", session.string(), "-o", whole.string()}, work_.path());
    EXPECT_EQ(recover.wait(), 0) << recover.err();
    const auto recovered = read_session_facts(whole);
    EXPECT_TRUE(recovered.complete);
    for (const auto& [topic, stream] : facts.streams) {
      EXPECT_GE(recovered.streams.at(topic).messages, stream.messages) << topic;
    }
    return facts;
  }

  const TemporaryFolder work_;
};

TEST_F(PowerCutTest, WhatIsOlderThanTwoSecondsSurvives) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> recording_s(3, 15);
  const int cuts = times("ROSEAU_POWER_CUTS", 20);
  for (int cut = 0; cut < cuts; ++cut) {
    SCOPED_TRACE("cut " + std::to_string(cut));
    make_disk(disk(), "128M");
    VirtualMachine machine(work_.path(), "record.sh", virtio_disk(disk()));
    ASSERT_TRUE(machine.wait_for("recording to", kBootLimit)) << machine.console();
    std::this_thread::sleep_for(std::chrono::duration<double>(recording_s(random)));
    machine.stop_dead();
    ASSERT_TRUE(read_disk(disk(), restored()));
    const auto facts = expect_recoverable(only_session(restored()));
    const double lost_s = last_beat_s(machine.console()) - to_seconds(facts.last_log_time.time_since_epoch());
    EXPECT_LE(lost_s, kMayBeLost_s);
    EXPECT_FALSE(facts.complete);
    EXPECT_TRUE(facts.counters) << "a checkpoint says what was received";
    std::printf("cut %d: %.1f s recorded, %.2f s lost\n", cut,
                to_seconds(facts.last_log_time - facts.first_log_time.value_or(facts.last_log_time)), lost_s);
  }
}

/// A real disk reorders what it has not been told to flush, and loses any part of it. The machine's writes are logged; disks
/// are made of them as a cut at some write would have left them: everything flushed before, and of the rest a random half.
TEST_F(PowerCutTest, EvenWhenTheDiskHadReorderedItsWrites) {
  make_disk(disk(), "128M");
  const auto empty = work_.path() / "empty.img";
  std::filesystem::copy_file(disk(), empty);
  const auto log_path = work_.path() / "writes.log";
  {
    VirtualMachine machine(work_.path(), "record.sh", logged_virtio_disk(disk(), log_path));
    ASSERT_TRUE(machine.wait_for("recording to", kBootLimit)) << machine.console();
    std::this_thread::sleep_for(std::chrono::seconds(25));
    machine.stop_dead();
  }
  const WriteLog log = read_write_log(log_path);
  ASSERT_GT(log.writes.size(), 40U);
  std::mt19937 random(1);
  // Not before two seconds are recorded: the first writes are the file system being mounted and the file being made.
  std::uniform_int_distribution<std::size_t> cut_at(log.writes.size() / 4, log.writes.size());
  const int cuts = times("ROSEAU_REORDERED_CUTS", 40);
  int sessions = 0;
  for (int i = 0; i < cuts; ++i) {
    const std::size_t cut = cut_at(random);
    SCOPED_TRACE("cut before write " + std::to_string(cut) + " of " + std::to_string(log.writes.size()));
    std::filesystem::copy_file(empty, disk(), std::filesystem::copy_options::overwrite_existing);
    apply_all(log, cut, disk());
    ASSERT_TRUE(read_disk(disk(), restored()));
    const auto untouched = read_session_facts(only_session(restored()));
    std::filesystem::copy_file(empty, disk(), std::filesystem::copy_options::overwrite_existing);
    apply_flushed_and_some(log, cut, disk(), random);
    ASSERT_TRUE(read_disk(disk(), restored()));
    const double recorded_s = to_seconds(untouched.last_log_time - untouched.first_log_time.value_or(untouched.last_log_time));
    if (recorded_s < kMayBeLost_s) continue;
    ++sessions;
    const auto facts = expect_recoverable(only_session(restored()));
    EXPECT_LE(to_seconds(untouched.last_log_time - facts.last_log_time), kMayBeLost_s);
  }
  EXPECT_GT(sessions, cuts / 2);
}

}  // namespace
}  // namespace roseau::testing
