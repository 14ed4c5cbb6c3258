#include "daemon/analysis.h"

#include <gtest/gtest.h>

#include <chrono>

namespace roseau::daemon {
namespace {

/// Answers every frame of its device with one displacement; odd cameras are slow, so that results come in another order.
class CountingTracker : public Stage {
 public:
  CountingTracker(StreamId frames, StreamId out, bool slow) : frames_(frames), out_(out), slow_(slow) {}
  void process(const Sample& input, SampleSink& out) override {
    if (input.header.stream != frames_) return;
    if (slow_ && input.header.sequence % 5 == 0) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    Sample result;
    result.header = input.header;
    result.header.stream = out_;
    result.payload = Displacement{.x = static_cast<double>(input.header.sequence)};
    out.receive(std::move(result));
  }

 private:
  StreamId frames_;
  StreamId out_;
  bool slow_;
};

/// Sums every displacement it sees: order matters, because it answers with the running sum.
class RunningSum : public Stage {
 public:
  explicit RunningSum(StreamId out) : out_(out) {}
  void process(const Sample& input, SampleSink& out) override {
    const auto* displacement = std::get_if<Displacement>(&input.payload);
    if (displacement == nullptr) return;
    sum_ = sum_ * 1.0000001 + displacement->x * static_cast<double>(input.header.stream);
    Sample result;
    result.header = input.header;
    result.header.stream = out_;
    result.payload = WindEstimate{.wind_mps = sum_};
    out.receive(std::move(result));
  }

 private:
  StreamId out_;
  double sum_ = 0;
};

std::vector<double> run_once(int frames, std::size_t capacity) {
  StreamTable streams;
  std::vector<StreamId> images;
  std::vector<Analysis::Tracker> trackers;
  const auto sum_stream = streams.add({.topic = "/sum", .kind = "wind_estimate", .role = StreamRole::derived});
  for (int camera = 0; camera < 3; ++camera) {
    const std::string device = "camera" + std::to_string(camera);
    images.push_back(streams.add({.topic = "/" + device + "/image", .kind = "frame", .device = device}));
    const auto out = streams.add({.topic = "/" + device + "/target/a/displacement",
                                  .kind = "displacement",
                                  .role = StreamRole::derived,
                                  .device = device});
    trackers.push_back({device, std::make_unique<CountingTracker>(images.back(), out, camera % 2 == 1)});
  }
  std::vector<double> outputs;
  Analysis analysis(
      streams, std::move(trackers), std::make_unique<RunningSum>(sum_stream),
      [&outputs](const Sample& sample, HostTime) {
        if (const auto* wind = std::get_if<WindEstimate>(&sample.payload)) outputs.push_back(wind->wind_mps);
      },
      capacity);
  for (int i = 0; i < frames; ++i) {
    for (const StreamId image : images) {
      Sample frame;
      frame.header.stream = image;
      frame.header.sequence = static_cast<std::uint32_t>(i);
      frame.payload = Frame{};
      analysis.submit(std::move(frame), host_time_from_ns(i));
    }
  }
  analysis.finish();
  return outputs;
}

TEST(Analysis, OutputIsOneOrderWhateverTheThreadsDo) {
  const auto reference = run_once(100, 256);
  ASSERT_EQ(reference.size(), 300U);
  EXPECT_EQ(run_once(100, 256), reference);
  EXPECT_EQ(run_once(100, 4), reference) << "a short queue waits, it does not change anything";
}

TEST(Analysis, WhatNoTrackerWantsPassesInItsPlace) {
  StreamTable streams;
  const auto raw = streams.add({.topic = "/truth/wind", .kind = "wind"});
  const auto wind = streams.add({.topic = "/sonic/wind", .kind = "wind", .role = StreamRole::derived});
  std::vector<StreamId> seen;
  Analysis analysis(streams, {}, std::make_unique<RunningSum>(wind),
                    [&seen](const Sample& sample, HostTime) { seen.push_back(sample.header.stream); });
  for (const StreamId stream : {raw, wind, raw}) {
    Sample sample;
    sample.header.stream = stream;
    sample.payload = WindSample{};
    analysis.submit(std::move(sample), HostTime{});
  }
  analysis.finish();
  EXPECT_EQ(seen, (std::vector<StreamId>{raw, wind, raw}));
}

}  // namespace
}  // namespace roseau::daemon
