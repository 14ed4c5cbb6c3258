// Disks that go away under a recording, by the kernel's own doing: the program says so and runs on, and what was written is a
// session.

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "tests/hardware/recording_guest.h"
#include "tests/hardware/virtual_machine.h"
#include "tests/support/session_facts.h"

namespace roseau::testing {
namespace {

using ::testing::HasSubstr;

constexpr auto kLimit = std::chrono::seconds(180);
constexpr int kRecording_s = 14;

class DiskFaultTest : public ::testing::Test {
 protected:
  std::filesystem::path disk() const { return work_.path() / "disk.img"; }

  /// The disk's fault comes after about five seconds of recording.
  void record(const std::string& prepare, const std::string& fault, const std::vector<std::string>& qemu_arguments) {
    const std::string wait = "until ls /tmp/disk/*.mcap >/dev/null 2>&1; do sleep 0.2; done; sleep 5; echo FAULT; ";
    write_recording_guest(work_, prepare, wait + fault, kRecording_s);
    VirtualMachine machine(work_.path(), "record.sh", qemu_arguments);
    status_ = machine.wait_for_end(kLimit);
    console_ = machine.console();
    ASSERT_TRUE(status_) << console_;
    summary_ = nlohmann::json::parse(read_text_file(work_.path() / "summary.json"), nullptr, false);
    ASSERT_FALSE(summary_.is_discarded()) << console_;
  }
  /// Samples of the whole run, although the disk was there for only a part of it.
  void expect_ran_on() const {
    EXPECT_EQ(status_, 1) << console_;
    EXPECT_GT(summary_["streams"]["/camera0/image"]["received"], 100) << console_;
    EXPECT_GT(summary_["streams"]["/camera0/image"]["dropped"], 30) << console_;
    EXPECT_GT(summary_["streams"]["/sonic/raw"]["received"], 20) << console_;
  }
  void expect_session_on_disk() const {
    ASSERT_TRUE(read_disk(disk(), work_.path() / "restored"));
    const auto facts = read_session_facts(only_session(work_.path() / "restored"));
    const auto& camera = facts.streams.at("/camera0/image");
    EXPECT_GT(camera.messages, 30U);
    EXPECT_EQ(camera.missing, 0U);
    // The system may have taken the last two seconds and lost them: no more than that is counted as recorded and not there.
    constexpr std::uint64_t kRate_hz = 10;
    EXPECT_GE(camera.messages + 2 * kRate_hz, summary_["streams"]["/camera0/image"]["recorded"].get<std::uint64_t>());
  }

  const TemporaryFolder work_;
  std::optional<int> status_;
  std::string console_;
  nlohmann::json summary_;
};

TEST_F(DiskFaultTest, UsbDiskUnplugged) {
  make_disk(disk(), "128M");
  record(
      "for m in xhci-pci usb-storage sd_mod ext4; do $MP $m; done; until [ -b /dev/sda ]; do sleep 0.1; done;"
      "mount /dev/sda /tmp/disk || exit 3",
      "for d in /sys/bus/usb/devices/[0-9]*-[0-9]; do echo 1 > $d/remove; done",
      {"-device", "qemu-xhci", "-drive", fmt::format("if=none,id=stick,file={},format=raw", disk().string()), "-device",
       "usb-storage,drive=stick"});
  expect_ran_on();
  EXPECT_THAT(console_, ::testing::AnyOf(HasSubstr("Input/output error"), HasSubstr("No such device"),
                                         HasSubstr("Read-only file system")));
  expect_session_on_disk();
}

TEST_F(DiskFaultTest, RemountedReadOnly) {
  make_disk(disk(), "128M");
  record("$MP virtio_blk && $MP ext4 && mount /dev/vda /tmp/disk || exit 3", "echo u > /proc/sysrq-trigger",
         virtio_disk(disk()));
  expect_ran_on();
  EXPECT_THAT(console_, HasSubstr("Read-only file system"));
  expect_session_on_disk();
}

}  // namespace
}  // namespace roseau::testing
