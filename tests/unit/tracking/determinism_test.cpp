// Same inputs, same bits: from run to run, for any number of OpenCV threads, and when a run is taken up from a checkpoint.
#include <gtest/gtest.h>

#include <opencv2/core/utility.hpp>

#include "tests/unit/tracking/run.h"

namespace roseau::tracking {
namespace {

using testing::Picture;
using testing::Texture;
using testing::TrackerRun;

/// Everything that tracking does: given targets or automatic ones, an operator's action, an occlusion, a broken frame.
class Story {
 public:
  explicit Story(bool automatic) {
    options.feature_count = 150;
    options.automatic_frames = 25;
    if (!automatic) options.targets = {{"left", {40, 40, 70, 90}}, {"right", {130, 40, 70, 90}}};
    const Texture wall(21, 30, 30);
    const Texture branch(22, 30, 30);
    const Texture board(23, 30, 30);
    std::mt19937_64 random(24);
    for (int i = 0; i < kFrames; ++i) {
      Picture picture(240, 180);
      const Eigen::Vector2d shake(0.6 * std::sin(0.9 * i), 0);
      picture.draw(wall, {.shift = shake});
      picture.draw(branch, {.shift = shake + Eigen::Vector2d(4 * std::sin(0.2 * i), 0), .centre = {120, 90}},
                   ImageRect{30, 30, 180, 110});
      if (i >= 40 && i < 50) picture.draw(board, {}, ImageRect{20, 20, 105, 150});
      picture.add_noise(2, random);
      pictures.push_back(std::move(picture));
    }
  }
  static constexpr int kFrames = 70;

  void tell(TrackerRun& run, int from, int to) const {
    run.index = from;
    for (int i = from; i < to; ++i) {
      if (i == 30) {
        run.act({.kind = OperatorAction::Kind::add_target, .text = "added", .camera = "camera0", .region = {90, 50, 60, 60}});
      }
      run.frame(pictures[static_cast<std::size_t>(i)], i == 55 ? kStatusIncomplete : kStatusOk);
    }
  }

  TrackerOptions options;
  std::vector<Picture> pictures;
};

class Determinism : public ::testing::TestWithParam<bool> {
 protected:
  void TearDown() override { cv::setNumThreads(threads_before_); }
  const Story story_{GetParam()};
  const int threads_before_ = cv::getNumThreads();
};

TEST_P(Determinism, TwoRunsGiveTheSameBits) {
  TrackerRun first(story_.options);
  TrackerRun second(story_.options);
  story_.tell(first, 0, Story::kFrames);
  story_.tell(second, 0, Story::kFrames);
  ASSERT_GT(first.bits().size(), 100000U);
  EXPECT_TRUE(first.bits() == second.bits());
}

TEST_P(Determinism, ThreadsOfOpenCvDoNotMatter) {
  cv::setNumThreads(1);
  TrackerRun one(story_.options);
  story_.tell(one, 0, Story::kFrames);
  cv::setNumThreads(2);
  TrackerRun two(story_.options);
  story_.tell(two, 0, Story::kFrames);
  cv::setNumThreads(5);
  TrackerRun five(story_.options);
  story_.tell(five, 0, Story::kFrames);
  EXPECT_TRUE(one.bits() == two.bits());
  EXPECT_TRUE(one.bits() == five.bits());
}

TEST_P(Determinism, WhatIsSaidDependsOnThePictures) {
  TrackerRun first(story_.options);
  story_.tell(first, 0, 30);
  Story other(GetParam());
  other.pictures[20].scale_light(1.001, 0);
  TrackerRun second(story_.options);
  other.tell(second, 0, 30);
  EXPECT_FALSE(first.bits() == second.bits());
}

TEST_P(Determinism, ACheckpointTakesARunUpWithTheSameBits) {
  TrackerRun whole(story_.options);
  story_.tell(whole, 0, Story::kFrames);
  // Before the first frame, while watching, after the operator's action, while the target is hidden, after a broken frame.
  for (const int at : {0, 1, 13, 31, 44, 56, 69}) {
    TrackerRun first(story_.options);
    story_.tell(first, 0, at);
    std::vector<std::byte> checkpoint;
    first.tracker.save(checkpoint);
    TrackerRun second(story_.options);
    // A used tracker forgets what it knew.
    story_.tell(second, 0, 3);
    const std::size_t used = second.collected.samples.size();
    const auto loaded = second.tracker.load(checkpoint);
    ASSERT_TRUE(loaded) << loaded.error().message;
    story_.tell(second, at, Story::kFrames);
    EXPECT_TRUE(whole.bits(first.collected.samples.size()) == second.bits(used)) << "checkpoint at frame " << at;
    std::vector<std::byte> again;
    TrackerRun third(story_.options);
    ASSERT_TRUE(third.tracker.load(checkpoint));
    third.tracker.save(again);
    EXPECT_TRUE(checkpoint == again) << "checkpoint at frame " << at;
  }
}

TEST_P(Determinism, ADamagedCheckpointIsRefusedAndLeavesANewTracker) {
  TrackerRun run(story_.options);
  story_.tell(run, 0, 35);
  std::vector<std::byte> checkpoint;
  run.tracker.save(checkpoint);
  TrackerRun fresh(story_.options);
  story_.tell(fresh, 0, 5);
  for (std::size_t size = 0; size < checkpoint.size(); size += 1 + checkpoint.size() / 97) {
    TrackerRun other(story_.options);
    const auto loaded = other.tracker.load(std::span(checkpoint).first(size));
    ASSERT_FALSE(loaded) << size;
    EXPECT_NE(loaded.error().message.find("camera0"), std::string::npos);
    if (size % 5 != 0) continue;
    story_.tell(other, 0, 5);
    EXPECT_TRUE(other.bits() == fresh.bits()) << size;
  }
  checkpoint.push_back(std::byte{0});
  EXPECT_FALSE(TrackerRun(story_.options).tracker.load(checkpoint)) << "too long";
}

// Whatever the bytes are, loading and going on neither crashes nor reads outside.
TEST_P(Determinism, FlippedBytesAreSurvived) {
  TrackerRun run(story_.options);
  story_.tell(run, 0, 32);
  std::vector<std::byte> checkpoint;
  run.tracker.save(checkpoint);
  std::mt19937_64 random(5);
  for (int trial = 0; trial < 60; ++trial) {
    std::vector<std::byte> damaged = checkpoint;
    // The picture is the larger part; aim at the state behind it.
    const std::size_t behind = 240 * 180 + 200;
    for (int i = 0; i < 4; ++i) {
      damaged[behind + random() % (damaged.size() - behind)] = static_cast<std::byte>(random() & 0xff);
    }
    TrackerRun other(story_.options);
    (void)other.tracker.load(damaged);
    story_.tell(other, 32, 36);
  }
}

TEST_P(Determinism, ACheckpointOfOtherOptionsIsRefused) {
  TrackerRun run(story_.options);
  story_.tell(run, 0, 5);
  std::vector<std::byte> checkpoint;
  run.tracker.save(checkpoint);
  TrackerOptions others = story_.options;
  others.window_px = 21;
  const auto loaded = TrackerRun(others).tracker.load(checkpoint);
  ASSERT_FALSE(loaded);
  EXPECT_EQ(loaded.error().code, ErrorCode::unsupported);
}

INSTANTIATE_TEST_SUITE_P(Targets, Determinism, ::testing::Bool(),
                         [](const auto& which) { return which.param ? "automatic" : "given"; });

}  // namespace
}  // namespace roseau::tracking
