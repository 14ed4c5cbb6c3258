#include "daemon/digest.h"

#include <gtest/gtest.h>

namespace roseau::daemon {
namespace {

class DigestTest : public ::testing::Test {
 protected:
  Sample wind(StreamId stream, std::int64_t time_ns, double u_mps) {
    Sample sample;
    sample.header.stream = stream;
    sample.header.sample_time = host_time_from_ns(time_ns);
    sample.payload = WindSample{.u_mps = u_mps};
    return sample;
  }
  StreamTable streams_;
  StreamId a_ = streams_.add({.topic = "/a/wind", .kind = "wind", .role = StreamRole::derived});
  StreamId b_ = streams_.add({.topic = "/b/wind", .kind = "wind", .role = StreamRole::derived});
  StreamId raw_ = streams_.add({.topic = "/c/wind", .kind = "wind", .role = StreamRole::raw});
  StreamId health_ = streams_.add({.topic = "/roseau/health", .kind = "health", .role = StreamRole::health});
};

TEST_F(DigestTest, OfNothingIsSha256OfNothing) {
  EXPECT_EQ(Digest().hex(), "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
}

TEST_F(DigestTest, EveryPartCounts) {
  const auto of = [this](StreamId stream, std::int64_t time_ns, double u_mps) {
    Digest digest;
    digest.add(wind(stream, time_ns, u_mps), streams_);
    return digest.hex();
  };
  EXPECT_EQ(of(a_, 1, 2.0), of(a_, 1, 2.0));
  EXPECT_NE(of(a_, 1, 2.0), of(b_, 1, 2.0));
  EXPECT_NE(of(a_, 1, 2.0), of(a_, 2, 2.0));
  EXPECT_NE(of(a_, 1, 2.0), of(a_, 1, 2.0000000000000004));
}

TEST_F(DigestTest, OrderCountsAndInputsAndHealthDoNot) {
  Digest forward;
  forward.add(wind(a_, 1, 1), streams_);
  forward.add(wind(b_, 1, 1), streams_);
  Digest backward;
  backward.add(wind(b_, 1, 1), streams_);
  backward.add(wind(a_, 1, 1), streams_);
  EXPECT_NE(forward.hex(), backward.hex());

  const std::string before = forward.hex();
  forward.add(wind(raw_, 1, 1), streams_);
  forward.add(wind(health_, 1, 1), streams_);
  EXPECT_EQ(forward.hex(), before);
}

}  // namespace
}  // namespace roseau::daemon
