#include "drivers/link/serial_stream.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include "drivers/link/pty_stream.h"
#include "tests/support/temporary_folder.h"
#include "tests/unit/drivers/link/stream_support.h"

namespace roseau::link {
namespace {

using std::chrono::milliseconds;
using ::testing::HasSubstr;

// The far side of a real pseudo terminal, opened as the driver opens an instrument's port.
class SerialOnPty : public ::testing::Test {
 protected:
  void SetUp() override {
    const auto opened = instrument_.open();
    ASSERT_TRUE(opened) << opened.error().message;
  }
  SerialStream make_port(int baud = 9600) const { return {instrument_.port_path(), SerialSettings{.baud = baud}}; }

  PtyStream instrument_;
};

TEST_F(SerialOnPty, CarriesEveryByteValueBothWays) {
  auto port = make_port();
  ASSERT_TRUE(port.open());
  std::string all(256, '\0');
  for (std::size_t i = 0; i < all.size(); ++i) all[i] = static_cast<char>(i);
  ASSERT_TRUE(instrument_.write(bytes_of(all)));
  EXPECT_EQ(read_text(port, all.size()), all);
  ASSERT_TRUE(port.write(bytes_of(all)));
  EXPECT_EQ(read_text(instrument_, all.size()), all);
}

TEST_F(SerialOnPty, FirstByteIsBackDatedAndNeverGoesBackwards) {
  auto port = make_port(9600);
  ASSERT_TRUE(port.open());
  std::array<std::byte, 64> buffer{};
  HostTime before{};
  for (int record = 0; record < 20; ++record) {
    ASSERT_TRUE(instrument_.write(bytes_of("Q,229,002.74,M,00,")));
    const auto received = port.read(buffer, milliseconds{1000});
    ASSERT_TRUE(received);
    ASSERT_EQ(received->size, 18U);
    EXPECT_LE(received->first_byte_time, monotonic_now());
    EXPECT_GE(received->first_byte_time, before);
    if (record == 0) {
      EXPECT_LE(received->first_byte_time, monotonic_now() - port.byte_time() * 18);
    }
    before = received->first_byte_time;
  }
}

TEST_F(SerialOnPty, NothingWithinTheTimeoutIsNoError) {
  auto port = make_port();
  ASSERT_TRUE(port.open());
  std::array<std::byte, 8> buffer{};
  const auto received = port.read(buffer, milliseconds{1});
  ASSERT_TRUE(received);
  EXPECT_EQ(received->size, 0U);
  EXPECT_FALSE(received->finished);
}

TEST_F(SerialOnPty, UnpluggedIsDisconnectedAndNamesThePort) {
  auto port = make_port();
  ASSERT_TRUE(port.open());
  const std::string path = instrument_.port_path();
  instrument_.close();
  const Error error = read_until_error(port);
  EXPECT_EQ(error.code, ErrorCode::disconnected);
  EXPECT_THAT(error.message, HasSubstr(path));
}

TEST_F(SerialOnPty, APortInUseIsBusy) {
  auto first = make_port();
  ASSERT_TRUE(first.open());
  auto second = make_port();
  const auto opened = second.open();
  ASSERT_FALSE(opened);
  EXPECT_EQ(opened.error().code, ErrorCode::busy);
  EXPECT_THAT(opened.error().message, HasSubstr("in use by another program"));
  first.close();
  EXPECT_TRUE(second.open());
}

TEST_F(SerialOnPty, CanBeReopenedAfterUnplugging) {
  auto port = make_port();
  ASSERT_TRUE(port.open());
  port.close();
  ASSERT_TRUE(port.open());
  ASSERT_TRUE(instrument_.write(bytes_of("again")));
  EXPECT_EQ(read_text(port, 5), "again");
}

TEST(SerialStream, AbsentPortSaysSo) {
  SerialStream port("/dev/ttyDoesNotExist", {});
  const auto opened = port.open();
  ASSERT_FALSE(opened);
  EXPECT_EQ(opened.error().code, ErrorCode::not_found);
  EXPECT_THAT(opened.error().message, HasSubstr("/dev/ttyDoesNotExist does not exist"));
}

TEST(SerialStream, AFileIsNoSerialPort) {
  const roseau::testing::TemporaryFolder folder;
  const auto path = folder.write("not-a-port", "");
  SerialStream port(path, {});
  const auto opened = port.open();
  ASSERT_FALSE(opened);
  EXPECT_THAT(opened.error().message, HasSubstr(path));
}

// Root may open everything, so the attempt is made by a child process that is nobody.
TEST(SerialStream, WithoutPermissionTheGroupIsNamed) {
  const roseau::testing::TemporaryFolder folder;
  const auto path = folder.write("port", "");
  ASSERT_EQ(::chmod(path.c_str(), 0), 0);
  ASSERT_EQ(::chmod(folder.path().c_str(), 0755), 0);
  const pid_t child = ::fork();
  if (child == 0) {
    constexpr uid_t kNobody = 65534;
    if (::geteuid() == 0 && ::setuid(kNobody) != 0) ::_exit(2);
    SerialStream port(path, {});
    const auto opened = port.open();
    const bool named = !opened && opened.error().code == ErrorCode::permission &&
                       opened.error().message.find("group dialout") != std::string::npos;
    ::_exit(named ? 0 : 1);
  }
  int status = 0;
  ASSERT_EQ(::waitpid(child, &status, 0), child);
  ASSERT_TRUE(WIFEXITED(status));
  EXPECT_EQ(WEXITSTATUS(status), 0);
}

}  // namespace
}  // namespace roseau::link
