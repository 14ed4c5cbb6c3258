#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "drivers/link/tcp_stream.h"
#include "drivers/link/udp_stream.h"
#include "tests/unit/drivers/link/stream_support.h"

namespace roseau::link {
namespace {

using std::chrono::milliseconds;
using ::testing::HasSubstr;

constexpr const char* kLoopback = "127.0.0.1";

class TcpPair : public ::testing::Test {
 protected:
  void SetUp() override {
    const auto opened = server_.open();
    ASSERT_TRUE(opened) << opened.error().message;
    ASSERT_NE(server_.port(), 0);
  }
  TcpStream make_client() const { return {kLoopback, server_.port(), Duration{0}}; }

  TcpListenStream server_{kLoopback, 0, Duration{0}};
};

TEST_F(TcpPair, CarriesBytesBothWays) {
  auto client = make_client();
  ASSERT_TRUE(client.open());
  ASSERT_TRUE(client.write(bytes_of("to server")));
  EXPECT_EQ(read_text(server_, 9), "to server");
  ASSERT_TRUE(server_.write(bytes_of("to client")));
  EXPECT_EQ(read_text(client, 9), "to client");
}

TEST_F(TcpPair, ReadTimesAreHostMonotonic) {
  auto client = make_client();
  ASSERT_TRUE(client.open());
  const HostTime before = monotonic_now();
  ASSERT_TRUE(client.write(bytes_of("x")));
  std::array<std::byte, 8> buffer{};
  const auto received = server_.read(buffer, milliseconds{1000});
  ASSERT_TRUE(received);
  Received got = *received;
  if (got.size == 0) got = *server_.read(buffer, milliseconds{1000});  // the first read accepted the connection
  ASSERT_EQ(got.size, 1U);
  EXPECT_GE(got.first_byte_time, before);
  EXPECT_LE(got.first_byte_time, monotonic_now());
}

TEST_F(TcpPair, LargeWritesArriveWhole) {
  auto client = make_client();
  ASSERT_TRUE(client.open());
  const std::string large(100'000, 'w');
  ASSERT_TRUE(client.write(bytes_of(large)));
  EXPECT_EQ(read_text(server_, large.size()), large);
}

TEST_F(TcpPair, AClientWhoseServerLeavesIsDisconnected) {
  auto client = make_client();
  ASSERT_TRUE(client.open());
  ASSERT_TRUE(client.write(bytes_of("x")));
  EXPECT_EQ(read_text(server_, 1), "x");
  server_.close();
  EXPECT_EQ(read_until_error(client).code, ErrorCode::disconnected);
}

TEST_F(TcpPair, TheServerTellsOnceThatItsPeerLeftAndServesTheNext) {
  {
    auto first = make_client();
    ASSERT_TRUE(first.open());
    ASSERT_TRUE(first.write(bytes_of("one")));
    EXPECT_EQ(read_text(server_, 3), "one");
  }
  EXPECT_EQ(read_until_error(server_).code, ErrorCode::disconnected);
  auto second = make_client();
  ASSERT_TRUE(second.open());
  ASSERT_TRUE(second.write(bytes_of("two")));
  EXPECT_EQ(read_text(server_, 3), "two");
}

TEST_F(TcpPair, WritingToAVanishedPeerIsAnErrorAndNoSignal) {
  auto client = make_client();
  ASSERT_TRUE(client.open());
  ASSERT_TRUE(client.write(bytes_of("x")));
  EXPECT_EQ(read_text(server_, 1), "x");
  server_.close();
  Result<void> written;
  for (int i = 0; i < 100 && written; ++i) written = client.write(bytes_of("into the void"));
  ASSERT_FALSE(written);
  EXPECT_EQ(written.error().code, ErrorCode::disconnected);
}

TEST_F(TcpPair, WritingBeforeAnyoneConnectedIsAnError) {
  const auto written = server_.write(bytes_of("hello?"));
  ASSERT_FALSE(written);
  EXPECT_EQ(written.error().code, ErrorCode::disconnected);
}

TEST_F(TcpPair, ReopeningKeepsThePort) {
  const auto port = server_.port();
  server_.close();
  ASSERT_TRUE(server_.open());
  EXPECT_EQ(server_.port(), port);
}

TEST_F(TcpPair, APortInUseIsBusy) {
  TcpListenStream other(kLoopback, server_.port(), Duration{0});
  const auto opened = other.open();
  ASSERT_FALSE(opened);
  EXPECT_EQ(opened.error().code, ErrorCode::busy);
  EXPECT_THAT(opened.error().message, HasSubstr("choose another port"));
}

TEST_F(TcpPair, NobodyListeningIsRefused) {
  server_.close();
  auto client = make_client();
  const auto opened = client.open();
  ASSERT_FALSE(opened);
  EXPECT_EQ(opened.error().code, ErrorCode::disconnected);
  EXPECT_THAT(opened.error().message, HasSubstr("refuses the connection"));
}

TEST(Tcp, ListeningOnAForeignAddressSaysSo) {
  TcpListenStream server("192.0.2.1", 0, Duration{0});  // TEST-NET-1: nobody's
  const auto opened = server.open();
  ASSERT_FALSE(opened);
  EXPECT_THAT(opened.error().message, HasSubstr("no address of this machine"));
}

TEST(Udp, OneReadIsOneDatagramAndAnswersReachTheSender) {
  UdpStream receiver(UdpRole::listen, kLoopback, 0);
  ASSERT_TRUE(receiver.open());
  UdpStream sender(UdpRole::send, kLoopback, receiver.port());
  ASSERT_TRUE(sender.open());
  EXPECT_FALSE(receiver.write(bytes_of("nobody yet")));
  ASSERT_TRUE(sender.write(bytes_of("first")));
  ASSERT_TRUE(sender.write(bytes_of("second")));
  std::array<std::byte, 64> buffer{};
  EXPECT_EQ(receiver.read(buffer, milliseconds{1000})->size, 5U);
  EXPECT_EQ(receiver.read(buffer, milliseconds{1000})->size, 6U);
  EXPECT_EQ(receiver.read(buffer, milliseconds{1})->size, 0U);
  ASSERT_TRUE(receiver.write(bytes_of("answer")));
  EXPECT_EQ(read_text(sender, 6), "answer");
}

TEST(Udp, AMissingListenerIsNoFailure) {
  UdpStream receiver(UdpRole::listen, kLoopback, 0);
  ASSERT_TRUE(receiver.open());
  UdpStream sender(UdpRole::send, kLoopback, receiver.port());
  ASSERT_TRUE(sender.open());
  receiver.close();
  std::array<std::byte, 8> buffer{};
  for (int i = 0; i < 5; ++i) {
    EXPECT_TRUE(sender.write(bytes_of("anyone?")));
    EXPECT_TRUE(sender.read(buffer, milliseconds{1}));
  }
}

}  // namespace
}  // namespace roseau::link
