// What goes wrong in the field: each time a message that says what to do, and nothing lost that was recorded.

#include <arpa/inet.h>
#include <gmock/gmock.h>
#include <netinet/in.h>
#include <sys/mount.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cstring>
#include <filesystem>

#include "tests/system/daemon/program.h"

namespace roseau::testing {
namespace {

using ::testing::HasSubstr;

class BadInputTest : public ProgramTest {
 protected:
  void expect_failure(const Ran& ran, const std::string& words) const {
    EXPECT_EQ(ran.status, 1) << ran.err;
    EXPECT_THAT(ran.err, HasSubstr(words));
  }
};

TEST_F(BadInputTest, MissingSession) { expect_failure(run({"replay", path("nowhere.mcap")}), "nowhere.mcap"); }

TEST_F(BadInputTest, NotASession) {
  expect_failure(run({"replay", folder_.write("x.mcap", "hello, this is no session at all"), "--headless"}), "x.mcap");
}

TEST_F(BadInputTest, EmptySessionFile) { expect_failure(run({"info", folder_.write("x.mcap", "")}), "x.mcap"); }

TEST_F(BadInputTest, MoreModesThanATreeHas) {
  const std::string stick = folder_.write("stick.txt", "0.05 1 0 0 0 0 0 1 0\n0.04 1 0 0 1 0 0 1 1\n");
  EXPECT_EQ(run({"tree", stick, "--modes", "12"}).status, 0);
  expect_failure(run({"tree", stick, "--modes", "13"}), "at most 12");
  expect_failure(run({"tree", stick, "--modes", "3", "--young-modulus", "0"}), "Young");
  EXPECT_EQ(run({"tree", stick, "--density", "900"}).status, 2) << "a density without --modes does nothing";
}

TEST_F(BadInputTest, UnknownConfigKey) {
  const auto config = folder_.write("c.toml", "[display]\nprot = 1\n");
  expect_failure(run({"run", config}), "c.toml:2: unknown key 'prot'");
}

TEST_F(BadInputTest, ConfigurationWithoutDevices) {
  expect_failure(run({"run", folder_.write("c.toml", "name = 'x'\n")}), "names no device");
}

TEST_F(BadInputTest, WrongUseIsStatusTwo) {
  EXPECT_EQ(run({}).status, 2);
  EXPECT_EQ(run({"repaly", "x"}).status, 2);
  EXPECT_EQ(run({"replay", "x", "--speed", "-3"}).status, 2);
  EXPECT_EQ(run({"replay", "x", "--speed", "2", "--max"}).status, 2);
  EXPECT_EQ(run({"estimate", "x", "--band", "3:1"}).status, 2);
  EXPECT_EQ(run({"--help"}).status, 0);
}

TEST_F(BadInputTest, VideoWithoutFrames) {
  const auto video = folder_.write("v.avi", "RIFF....AVI LIST");
  expect_failure(run({"import", "-o", path("o.mcap"), "--video", video}), "v.avi");
  EXPECT_FALSE(std::filesystem::exists(path("o.mcap"))) << "nothing is left behind";
}

TEST_F(BadInputTest, SonicFileWithAMissingColumn) {
  const auto file = folder_.write("s.csv", "U,W,T_SONIC\n1,2,290\n1,2,290\n");
  expect_failure(run({"import", "-o", path("o.mcap"), "--sonic", file, "--sonic-rate", "20"}), "s.csv");
}

TEST_F(BadInputTest, ASessionIsNeverOverwritten) {
  const auto file = folder_.write("s.txt", "1\n2\n3\n4\n");
  const auto output = folder_.write("o.mcap", "precious");
  expect_failure(run({"import", "-o", output, "--displacement", file, "--rate", "4"}), "o.mcap");
  EXPECT_EQ(read_text_file(output), "precious");
}

TEST_F(BadInputTest, PortInUse) {
  const int listener = socket(AF_INET, SOCK_STREAM, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t size = sizeof address;
  ASSERT_EQ(bind(listener, reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
  ASSERT_EQ(listen(listener, 1), 0);
  ASSERT_EQ(getsockname(listener, reinterpret_cast<sockaddr*>(&address), &size), 0);
  const auto port = std::to_string(ntohs(address.sin_port));
  const auto ran = run({"run", live_config(), "--port", port, "--for", "1"});
  close(listener);
  expect_failure(ran, port);
  EXPECT_THAT(ran.err, HasSubstr("--port"));
}

TEST_F(BadInputTest, RecordingDirectoryThatCannotBe) {
  const auto blocker = folder_.write("file", "");
  expect_failure(run({"run", live_config(), "--headless", "--for", "1", "--record", blocker + "/inside"}),
                 "recording directory");
}

TEST_F(BadInputTest, GarbageAndSplitBytesOnTheSonic) {
  std::string bytes = "\x02Q,garbage\x03 00\r\n\xff\xff\x80";
  const std::string record = "\x02Q,+000.04,-000.04,+000.06,M,+347.06,+025.88,00,\x03";
  for (int i = 0; i < 20; ++i) {
    bytes += record + "28\r\n";
    if (i % 5 == 0) bytes += record + "29\r\n" + std::string(7, '\0');
  }
  const auto file = folder_.write("sonic.bin", bytes);
  const auto config =
      folder_.write("c.toml", "[[sonic]]\nname = 'sonic'\nmodel = 'gill_windmaster'\nport = 'file:" + file + "'\n");
  const auto ran = run({"run", config, "--headless", "--json", "--record", path("rec")});
  ASSERT_EQ(ran.status, 0) << ran.err;
  const auto streams = ran.json()["streams"];
  EXPECT_EQ(streams["/sonic/wind"]["received"], 20);
  EXPECT_GE(streams["/sonic/raw"]["bad"], 4);
  EXPECT_EQ(streams["/sonic/raw"]["received"], streams["/sonic/raw"]["recorded"]) << "garbage is recorded as it came";
}

TEST_F(BadInputTest, DeviceThatIsAbsentIsWaitedForWhileOthersRun) {
  const std::string record = "\x02Q,229,002.74,M,00,\x03";
  const auto bytes = folder_.write("s.bin", record + "16\r\n");
  const auto config = folder_.write("c.toml",
                                    "[[sonic]]\nname = 'gone'\nmodel = 'gill_windsonic'\nport = 'serial:/dev/ttyNOWHERE'\n"
                                    "[[sonic]]\nname = 'here'\nmodel = 'gill_windsonic'\nport = 'file:" +
                                        bytes + "'\n");
  const auto ran = run({"run", config, "--headless", "--json", "--for", "2"});
  EXPECT_EQ(ran.status, 0) << ran.err;
  EXPECT_THAT(ran.err, HasSubstr("/dev/ttyNOWHERE"));
  EXPECT_EQ(ran.json()["streams"]["/here/wind"]["received"], 1);
}

/// A small disk. Needs the right to mount.
class FullDiskTest : public ProgramTest {
 protected:
  void SetUp() override {
    std::filesystem::create_directory(disk());
    if (!mount_disk("12m")) GTEST_SKIP() << "no right to mount a small disk: " << std::strerror(errno);
  }
  bool mount_disk(const char* size) {
    if (mounted_) umount(disk().c_str());
    mounted_ = mount("tmpfs", disk().c_str(), "tmpfs", 0, (std::string("size=") + size).c_str()) == 0;
    return mounted_;
  }
  void TearDown() override {
    if (mounted_) umount(disk().c_str());
  }
  std::string disk() const { return path("disk"); }
  bool mounted_ = false;
};

TEST_F(FullDiskTest, RecordingEndsInTimeAndTheRestRunsOn) {
  ASSERT_TRUE(mount_disk("64m"));
  const auto config = live_config("[recording]\nleast_free_mib = 45\n");
  const auto ran = run({"run", config, "--headless", "--json", "--for", "6", "--record", disk()});
  EXPECT_EQ(ran.status, 0) << ran.err;
  EXPECT_THAT(ran.err, HasSubstr("Free some space or record to another disk"));
  EXPECT_GT(ran.json()["streams"]["/camera0/image"]["received"], 60) << "the rest of the program ran on";
  const auto verified = run({"verify", session_in(disk()), "--json"});
  EXPECT_EQ(verified.status, 0) << verified.out << verified.err;
  EXPECT_TRUE(verified.json()["whole"]);
}

TEST_F(FullDiskTest, WithoutAGuardRecordingSaysSoAndWhatWasWrittenIsASession) {
  const auto config = live_config("[recording]\nleast_free_mib = 0\n");
  const auto ran = run({"run", config, "--headless", "--json", "--for", "5", "--record", disk()});
  EXPECT_EQ(ran.status, 1);
  EXPECT_THAT(ran.err, HasSubstr("No space left"));
  EXPECT_GT(ran.json()["streams"]["/camera0/image"]["received"], 60) << "the rest of the program ran on";
  const auto info = run({"info", session_in(disk()), "--json"});
  ASSERT_EQ(info.status, 0) << info.err;
  EXPECT_GT(info.json()["streams"]["/camera0/image"]["messages"], 3);
}

}  // namespace
}  // namespace roseau::testing
