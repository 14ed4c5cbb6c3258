#include "drivers/link/link_spec.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace roseau::link {
namespace {

using ::testing::HasSubstr;

std::string problem_with(std::string_view text) {
  const auto stream = make_byte_stream(text);
  return stream ? "no error" : stream.error().message;
}

Duration byte_time_of(std::string_view text) {
  const auto stream = make_byte_stream(text);
  EXPECT_TRUE(stream) << stream.error().message;
  return (*stream)->byte_time();
}

TEST(LinkSpec, TakesASerialPortApart) {
  const auto spec = parse_link_spec("serial:/dev/ttyUSB0?baud=19200&parity=none");
  ASSERT_TRUE(spec) << spec.error().message;
  EXPECT_EQ(spec->scheme, "serial");
  EXPECT_EQ(spec->path, "/dev/ttyUSB0");
  EXPECT_EQ(spec->parameters.at("baud"), "19200");
  EXPECT_EQ(spec->parameters.at("parity"), "none");
}

TEST(LinkSpec, TakesHostsApart) {
  const auto tcp = parse_link_spec("tcp://sonic.lan:4001");
  ASSERT_TRUE(tcp);
  EXPECT_EQ(tcp->host, "sonic.lan");
  EXPECT_EQ(tcp->port, 4001);
  const auto ipv6 = parse_link_spec("tcp-listen://[::1]:0");
  ASSERT_TRUE(ipv6);
  EXPECT_EQ(ipv6->host, "::1");
  EXPECT_EQ(ipv6->port, 0);
}

TEST(LinkSpec, ThreeSlashesAreAnAbsolutePath) {
  const auto spec = parse_link_spec("file:///data/sonic.bin");
  ASSERT_TRUE(spec);
  EXPECT_EQ(spec->path, "/data/sonic.bin");
}

TEST(LinkSpec, ByteTimeCountsEveryBitOnTheWire) {
  EXPECT_EQ(byte_time_of("serial:/dev/ttyS9?baud=10000"), Duration{1'000'000});  // 1 + 8 + 1 bits of 0.1 ms
  EXPECT_EQ(byte_time_of("serial:/dev/ttyS9?baud=10000&parity=even"), Duration{1'100'000});
  EXPECT_EQ(byte_time_of("serial:/dev/ttyS9?baud=10000&bits=7&parity=odd&stop=2"), Duration{1'100'000});
  EXPECT_EQ(byte_time_of("serial:/dev/ttyS9"), Duration{1'041'666});  // 9600 8N1 unless told
  EXPECT_EQ(byte_time_of("tcp://127.0.0.1:4001"), Duration{0});
  EXPECT_EQ(byte_time_of("tcp://127.0.0.1:4001?baud=10000"), Duration{1'000'000});
}

TEST(LinkSpec, KnowsWhatIsLiveAndWhatKeepsMessagesApart) {
  EXPECT_FALSE((*make_byte_stream("file:/data/sonic.bin"))->is_live());
  EXPECT_TRUE((*make_byte_stream("pty:"))->is_live());
  EXPECT_TRUE((*make_byte_stream("udp-listen://127.0.0.1:0"))->keeps_messages_apart());
  EXPECT_FALSE((*make_byte_stream("tcp-listen://127.0.0.1:0"))->keeps_messages_apart());
}

TEST(LinkSpec, SaysWhatIsWrong) {
  EXPECT_THAT(problem_with("/dev/ttyUSB0"), HasSubstr("should begin with one of serial:, tcp://"));
  EXPECT_THAT(problem_with("bluetooth:sonic"), HasSubstr("should begin with one of"));
  EXPECT_THAT(problem_with("serial:"), HasSubstr("names no port"));
  EXPECT_THAT(problem_with("file:"), HasSubstr("names no file"));
  EXPECT_THAT(problem_with("tcp:127.0.0.1:4001"), HasSubstr("should begin with tcp://"));
  EXPECT_THAT(problem_with("tcp://127.0.0.1"), HasSubstr("should end in a port number"));
  EXPECT_THAT(problem_with("tcp://127.0.0.1:70000"), HasSubstr("should end in a port number"));
  EXPECT_THAT(problem_with("tcp://:4001"), HasSubstr("has no host"));
  EXPECT_THAT(problem_with("tcp://127.0.0.1:0"), HasSubstr("port 0"));
  EXPECT_THAT(problem_with("udp://0.0.0.0:5001"), HasSubstr("write udp-listen://"));
}

TEST(LinkSpec, SaysWhichParameterIsWrong) {
  EXPECT_THAT(problem_with("serial:/dev/ttyS9?baud=fast"), HasSubstr("baud=fast is not a whole number from 50 to 4000000"));
  EXPECT_THAT(problem_with("serial:/dev/ttyS9?baud=0"), HasSubstr("baud=0 is not"));
  EXPECT_THAT(problem_with("serial:/dev/ttyS9?parity=mark"), HasSubstr("parity=mark is not one of none, even, odd"));
  EXPECT_THAT(problem_with("serial:/dev/ttyS9?bauds=9600"),
              HasSubstr("unknown parameter 'bauds'; known here: baud, bits, parity, stop, flow"));
  EXPECT_THAT(problem_with("serial:/dev/ttyS9?baud"), HasSubstr("'baud' should read key=value"));
  EXPECT_THAT(problem_with("serial:/dev/ttyS9?baud=9600&baud=19200"), HasSubstr("'baud' is given twice"));
  EXPECT_THAT(problem_with("udp://127.0.0.1:5001?baud=9600"), HasSubstr("known here: none"));
}

TEST(LinkSpec, EveryErrorQuotesTheSpecification) {
  EXPECT_THAT(problem_with("tcp://127.0.0.1"), HasSubstr("link 'tcp://127.0.0.1'"));
}

}  // namespace
}  // namespace roseau::link
