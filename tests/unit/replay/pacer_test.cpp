#include "replay/pacer.h"

#include <gtest/gtest.h>

#include <limits>

namespace roseau::replay {
namespace {

using std::chrono::seconds;

HostTime at_s(std::int64_t time_s) { return HostTime{seconds(time_s)}; }

class PacerTest : public ::testing::Test {
 protected:
  HostTime now_ = at_s(1000);
  Pacer make(double speed) {
    return {at_s(50), at_s(110), speed, [this] { return now_; }};
  }
};

TEST_F(PacerTest, SamplesAreDueAtTheSpeed) {
  const auto pacer = make(4);
  EXPECT_EQ(pacer.until_due(at_s(50)), Duration{0});
  EXPECT_EQ(pacer.until_due(at_s(90)), Duration{seconds(10)});
  now_ = at_s(1011);
  EXPECT_LT(pacer.until_due(at_s(90)), Duration{0});
}

TEST_F(PacerTest, AsFastAsPossibleNeverWaits) {
  EXPECT_EQ(make(std::numeric_limits<double>::infinity()).until_due(at_s(110)), Duration{0});
}

TEST_F(PacerTest, PauseHoldsAndPlayGoesOnFromThere) {
  auto pacer = make(1);
  now_ = at_s(1010);
  pacer.reached(at_s(60));
  pacer.pause();
  EXPECT_EQ(pacer.until_due(at_s(61)), Duration::max());
  now_ = at_s(2000);
  pacer.play();
  EXPECT_EQ(pacer.until_due(at_s(61)), Duration{seconds(1)});
  EXPECT_EQ(pacer.state().position, at_s(60));
}

TEST_F(PacerTest, SpeedChangesFromHereOn) {
  auto pacer = make(1);
  now_ = at_s(1010);
  pacer.reached(at_s(60));
  pacer.set_speed(2);
  EXPECT_EQ(pacer.until_due(at_s(64)), Duration{seconds(2)});
  pacer.set_speed(-1);
  EXPECT_EQ(pacer.state().speed, 2);
}

TEST_F(PacerTest, LoopStartsAgainAtTheBeginning) {
  auto pacer = make(1);
  pacer.reached(at_s(110));
  pacer.end();
  EXPECT_TRUE(pacer.state().ended);
  now_ = at_s(1060);
  pacer.restart();
  EXPECT_FALSE(pacer.state().ended);
  EXPECT_EQ(pacer.until_due(at_s(51)), Duration{seconds(1)});
}

}  // namespace
}  // namespace roseau::replay
