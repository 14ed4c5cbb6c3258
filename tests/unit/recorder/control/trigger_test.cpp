#include "recorder/control/trigger.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace roseau::recorder {
namespace {

using namespace std::chrono_literals;
using ::testing::HasSubstr;

HostTime at_ms(std::int64_t time_ms) { return host_time_from_ns(time_ms * 1'000'000); }

/// What a trigger did: "+1200" fired at 1200 ms, "-3000" ended.
struct Watched {
  explicit Watched(TriggerOptions options) : trigger(std::move(options)) {}
  void see(std::int64_t time_ms, Payload payload, std::uint16_t status = kStatusOk) {
    const Sample sample{{.status = status, .arrival_time = at_ms(time_ms), .sample_time = at_ms(time_ms)}, std::move(payload)};
    note(trigger.see(sample, at_ms(time_ms)));
  }
  void note(const std::optional<TriggerEvent>& event) {
    if (!event) return;
    events +=
        (events.empty() ? "" : " ") + std::string(event->begins ? "+" : "-") + std::to_string(to_ns(event->at) / 1'000'000);
    reason = event->reason;
  }
  Trigger trigger;
  std::string events;
  std::string reason;
};

TriggerOptions speed_above(double above) {
  return {.name = "storm", .topic = "/sonic/wind", .quantity = TriggerQuantity::wind_speed_mps, .above = above};
}
WindSample wind(double u_mps, double v_mps = 0) { return {.u_mps = u_mps, .v_mps = v_mps, .w_mps = 0}; }

TEST(Trigger, FiresAboveAndEndsBelowTheHysteresis) {
  auto options = speed_above(10);
  options.hysteresis = 2;
  Watched watched(options);
  const double speeds[] = {9, 10, 10.5, 9, 8.1, 12, 7.9, 9, 11};
  for (int i = 0; i < 9; ++i) watched.see(100 * i, wind(0, speeds[i]));
  EXPECT_EQ(watched.events, "+200 -600 +800");
  EXPECT_EQ(watched.reason, "wind_speed_mps 11 on /sonic/wind, above 10");
}

TEST(Trigger, TheWindIsHorizontal) {
  Watched watched(speed_above(4.9));
  watched.see(0, WindSample{.u_mps = 0, .v_mps = 0, .w_mps = 50});
  EXPECT_EQ(watched.events, "");
  watched.see(10, WindSample{.u_mps = -3, .v_mps = 4, .w_mps = 0});
  EXPECT_EQ(watched.events, "+10");
}

TEST(Trigger, MustHoldForAsLongAsAskedWithoutABreak) {
  auto options = speed_above(10);
  options.for_at_least = 1s;
  Watched watched(options);
  for (int time_ms = 0; time_ms <= 3000; time_ms += 100) watched.see(time_ms, wind(time_ms == 800 ? 5 : 11));
  EXPECT_EQ(watched.events, "+1900");  // above again from 900 on
}

TEST(Trigger, RearmsOnlyAfterAWhile) {
  auto options = speed_above(10);
  options.rearm = 1s;
  Watched watched(options);
  for (int time_ms = 0; time_ms < 2100; time_ms += 100) watched.see(time_ms, wind(time_ms / 100 % 2 == 0 ? 11 : 9));
  EXPECT_EQ(watched.events, "+0 -100 +1000 -1100 +2000");
}

TEST(Trigger, BadSamplesSayNothing) {
  Watched watched(speed_above(10));
  watched.see(0, wind(99), kStatusBadChecksum);
  auto invalid = wind(99);
  invalid.valid = false;
  watched.see(10, invalid);
  watched.see(20, wind(kNotMeasured, 99));
  EXPECT_EQ(watched.events, "");
}

TEST(Trigger, EndsWhenTheInstrumentFallsSilent) {
  Watched watched(speed_above(10));
  watched.see(0, wind(11));
  watched.note(watched.trigger.tick(at_ms(4999)));
  EXPECT_EQ(watched.events, "+0");
  watched.note(watched.trigger.tick(at_ms(5000)));
  EXPECT_EQ(watched.events, "+0 -5000");
}

TEST(Trigger, GustIsAboveTheMeanOfItsWindow) {
  auto options = speed_above(3);
  options.quantity = TriggerQuantity::gust_mps;
  options.window = 10s;
  Watched watched(options);
  // 8 m/s for long, then 12: the mean over 10 s rises by 0.04 m/s a sample of 0.1 s, from 8.04 on.
  for (int time_ms = 0; time_ms < 20'000; time_ms += 100) watched.see(time_ms, wind(8));
  EXPECT_EQ(watched.events, "");
  for (int time_ms = 20'000; time_ms < 40'000; time_ms += 100) watched.see(time_ms, wind(12));
  // It ends with the k-th sample of which 4 (1 - k/101) is below 3.
  EXPECT_EQ(watched.events, "+20000 -22500");
}

TEST(Trigger, NoGustBeforeThereIsAMean) {
  auto options = speed_above(3);
  options.quantity = TriggerQuantity::gust_mps;
  options.window = 10s;
  Watched watched(options);
  watched.see(0, wind(1));
  watched.see(9900, wind(30));
  EXPECT_EQ(watched.events, "");
  watched.see(10'000, wind(30));
  EXPECT_EQ(watched.events, "+10000");
}

TEST(Trigger, EstimatesCountOnceAccepted) {
  Watched watched(speed_above(5));
  watched.see(0, WindEstimate{.wind_mps = -6, .accepted = false});
  EXPECT_EQ(watched.events, "");
  watched.see(10, WindEstimate{.wind_mps = -6, .accepted = true});
  EXPECT_EQ(watched.events, "+10");
}

/// A sine of amplitude A has an RMS of A / sqrt 2 and comes A away from its mean, whatever its mean is.
TEST(Trigger, DisplacementsCountAboutTheirMean) {
  const auto first_fired_ms = [](TriggerQuantity quantity, double above) {
    Watched watched({.name = "sway", .topic = "/d", .quantity = quantity, .above = above, .window = 4s});
    for (int time_ms = 0; time_ms <= 20'000; time_ms += 10) {
      const double angle = 2 * std::numbers::pi * time_ms / 1000;
      watched.see(time_ms, Displacement{.x = 700 + 3 * std::sin(angle), .y = -40 + 4 * std::sin(angle)});
    }
    return watched.events.substr(0, watched.events.find(' '));
  };
  // 5 px along one line.
  EXPECT_EQ(first_fired_ms(TriggerQuantity::displacement_rms, 3.6), "");
  EXPECT_EQ(first_fired_ms(TriggerQuantity::displacement_rms, 3.45), "+4000");  // as soon as a whole window was seen
  EXPECT_EQ(first_fired_ms(TriggerQuantity::displacement_amplitude, 5.1), "");
  EXPECT_EQ(first_fired_ms(TriggerQuantity::displacement_amplitude, 4.8), "+4210");
}

TEST(Trigger, LostTargetsDoNotMove) {
  Watched watched(
      {.name = "sway", .topic = "/d", .quantity = TriggerQuantity::displacement_amplitude, .above = 1, .window = 1s});
  for (int time_ms = 0; time_ms < 2000; time_ms += 100) watched.see(time_ms, Displacement{.x = 0});
  watched.see(2000, Displacement{.x = 99, .valid = false});
  EXPECT_EQ(watched.events, "");
}

TEST(SlidingMoments, StayExactForAVeryLongTime) {
  SlidingMoments moments(1s);
  for (int i = 0; i < 1'000'000; ++i) moments.add(at_ms(10 * i), 1e6 + (i % 2 == 0 ? 0.01 : -0.01));
  EXPECT_NEAR(moments.mean(), 1e6, 1e-3);
  EXPECT_NEAR(moments.variance(), 1e-4, 1e-6);
}

TEST(TriggerWatch, LooksAtTheTopicItWasTold) {
  StreamTable streams;
  const StreamId first = streams.add({.topic = "/a/wind", .kind = "wind"});
  const StreamId second = streams.add({.topic = "/b/wind", .kind = "wind"});
  auto options = speed_above(10);
  options.topic = "/b/wind";
  TriggerWatch watch({options}, streams);
  EXPECT_TRUE(watch.see({{.stream = first}, wind(11)}, at_ms(0)).empty());
  const auto events = watch.see({{.stream = second}, wind(11)}, at_ms(10));
  ASSERT_EQ(events.size(), 1U);
  EXPECT_EQ(events[0].name, "storm");
  EXPECT_TRUE(events[0].begins);
}

TEST(TriggerWatch, UnknownQuantityNamesThoseThatAre) {
  const auto quantity = trigger_quantity_from_string("speed");
  ASSERT_FALSE(quantity);
  EXPECT_THAT(quantity.error().message, HasSubstr("wind_speed_mps"));
  for (const auto known : {TriggerQuantity::wind_speed_mps, TriggerQuantity::gust_mps, TriggerQuantity::displacement_rms,
                           TriggerQuantity::displacement_amplitude}) {
    EXPECT_EQ(*trigger_quantity_from_string(to_string(known)), known);
  }
}

}  // namespace
}  // namespace roseau::recorder
