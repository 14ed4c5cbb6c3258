#include "drivers/link/first_byte_time.h"

#include <gtest/gtest.h>

namespace roseau::link {
namespace {

using std::chrono::milliseconds;

HostTime at_ms(std::int64_t time_ms) { return HostTime{milliseconds{time_ms}}; }

TEST(FirstByteTime, BackDatesByTheTimeOnTheWire) {
  FirstByteTime dating(milliseconds{1});
  EXPECT_EQ(dating.of_read(at_ms(1000), 24), at_ms(976));
  EXPECT_EQ(dating.of_read(at_ms(2000), 10), at_ms(1990));
}

TEST(FirstByteTime, TwoReadsCannotOverlapOnTheWire) {
  FirstByteTime dating(milliseconds{1});
  EXPECT_EQ(dating.of_read(at_ms(1000), 10), at_ms(990));  // on the wire until 1000
  EXPECT_EQ(dating.of_read(at_ms(1003), 8), at_ms(1000));  // 995 by itself: 5 of the 8 bytes would lie below the others
}

TEST(FirstByteTime, NeverRunsBackwardsNorAheadWhenBytesComeFasterThanStated) {
  FirstByteTime dating(milliseconds{1});
  HostTime before = dating.of_read(at_ms(1000), 100);
  for (int i = 1; i <= 50; ++i) {
    const HostTime read_time = at_ms(1000 + i);
    const HostTime first = dating.of_read(read_time, 100);
    EXPECT_GE(first, before);
    EXPECT_LE(first, read_time);
    before = first;
  }
}

TEST(FirstByteTime, WithoutByteTimeTheReadCounts) {
  FirstByteTime dating(Duration{0});
  EXPECT_EQ(dating.of_read(at_ms(5), 1000), at_ms(5));
}

TEST(FirstByteTime, ReopeningForgetsWhatCameBefore) {
  FirstByteTime dating(milliseconds{1});
  EXPECT_EQ(dating.of_read(at_ms(1000), 10), at_ms(990));
  dating.reset();
  EXPECT_EQ(dating.of_read(at_ms(1003), 8), at_ms(995));
}

}  // namespace
}  // namespace roseau::link
