#include "replay/pacer.h"

#include <gtest/gtest.h>

#include <limits>
#include <thread>

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

TEST_F(PacerTest, ASeekGoesOnFromTheNewPlace) {
  auto pacer = make(2);
  now_ = at_s(1004);
  pacer.reached(at_s(58));
  pacer.seek(at_s(90));
  EXPECT_EQ(pacer.state().position, at_s(90));
  EXPECT_EQ(pacer.state().jumps, 1U);
  EXPECT_EQ(pacer.state().jumps_done, 0U);
  EXPECT_EQ(pacer.until_due(at_s(94)), Duration{seconds(2)});
  pacer.reached(at_s(59));
  EXPECT_EQ(pacer.state().position, at_s(90)) << "a sample from before was still on its way";
  EXPECT_EQ(pacer.take_seek(), at_s(90));
  EXPECT_EQ(pacer.state().jumps_done, 1U);
  EXPECT_FALSE(pacer.take_seek());
  pacer.reached(at_s(88));
  EXPECT_EQ(pacer.state().position, at_s(90)) << "what leads up to the place does not move it";
  pacer.reached(at_s(91));
  EXPECT_EQ(pacer.state().position, at_s(91));
}

TEST_F(PacerTest, SeeksStayInTheSession) {
  auto pacer = make(1);
  pacer.seek(at_s(7));
  EXPECT_EQ(pacer.state().position, at_s(50));
  pacer.seek(HostTime::max());
  EXPECT_EQ(pacer.take_seek(), at_s(110));
}

TEST_F(PacerTest, ASeekWhilePausedStaysPausedButIsShown) {
  auto pacer = make(1);
  pacer.set_lookahead(seconds(1));
  pacer.pause();
  EXPECT_EQ(pacer.until_due(at_s(50)), Duration::max());
  pacer.seek(at_s(80));
  pacer.take_seek();
  EXPECT_EQ(pacer.until_due(at_s(79)), Duration{0});
  pacer.reached(at_s(79));
  EXPECT_EQ(pacer.until_due(at_s(83)), Duration{0}) << "the first that is late enough closes the view";
  pacer.reached(at_s(83));
  EXPECT_EQ(pacer.until_due(at_s(83)), Duration::max());
  EXPECT_FALSE(pacer.state().playing);
  EXPECT_EQ(pacer.state().position, at_s(80));
}

TEST_F(PacerTest, PlayAtTheEndStartsOver) {
  auto pacer = make(1);
  pacer.end();
  pacer.play();
  EXPECT_FALSE(pacer.state().ended);
  EXPECT_EQ(pacer.take_seek(), at_s(50));
  pacer.seek(at_s(110));
  pacer.take_seek();
  pacer.pause();
  pacer.play();
  EXPECT_EQ(pacer.take_seek(), at_s(50)) << "paused at the very end";
}

TEST_F(PacerTest, WaitingEndsWhenSomebodySeeks) {
  auto pacer = make(1);
  pacer.pause();
  std::jthread viewer([&pacer] {
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
    pacer.seek(at_s(60));
  });
  // Far longer than the test may take: it ends by the seek.
  EXPECT_EQ(pacer.wait_until_due(at_s(55), seconds(600)), Duration{0});
  EXPECT_TRUE(pacer.has_seek());
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
