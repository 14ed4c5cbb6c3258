// Runs a CameraTracker over pictures and keeps what it says.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "core/source.h"
#include "tests/unit/tracking/scene.h"
#include "tracking/camera_tracker.h"

namespace roseau::tracking::testing {

class Collector final : public SampleSink {
 public:
  bool receive(Sample sample) override {
    samples.push_back(std::move(sample));
    return true;
  }
  std::vector<Sample> samples;
};

class TrackerRun {
 public:
  explicit TrackerRun(TrackerOptions options = {}) : tracker(streams, "camera0", std::move(options)) {}

  void frame(const Picture& picture, std::uint16_t status = kStatusOk) {
    Sample sample = sample_of(frame_of(picture), image, index++);
    sample.header.status = status;
    tracker.process(sample, collected);
  }
  void act(OperatorAction action) {
    SampleHeader header;
    header.stream = operator_stream;
    tracker.process({header, std::move(action)}, collected);
  }
  std::vector<Displacement> displacements(const std::string& target) const {
    std::vector<Displacement> all;
    const auto stream = streams.find("/camera0/target/" + target + "/displacement");
    for (const Sample& sample : collected.samples) {
      if (stream && sample.header.stream == *stream) all.push_back(std::get<Displacement>(sample.payload));
    }
    return all;
  }
  std::vector<ImageMotion> motions() const {
    std::vector<ImageMotion> all;
    for (const Sample& sample : collected.samples) {
      if (const auto* motion = std::get_if<ImageMotion>(&sample.payload)) all.push_back(*motion);
    }
    return all;
  }

  /// Everything said from sample `from` on, bit for bit.
  std::string bits(std::size_t from = 0) const {
    std::string all;
    const auto add = [&all](const auto&... values) {
      (all.append(reinterpret_cast<const char*>(&values), sizeof(values)), ...);
    };
    const auto add_region = [&](const ImageRect& r) { add(r.x, r.y, r.width, r.height); };
    for (std::size_t i = from; i < collected.samples.size(); ++i) {
      const Sample& sample = collected.samples[i];
      all += streams.info(sample.header.stream).topic;
      add(sample.header.sequence, to_ns(sample.header.sample_time), to_ns(sample.header.arrival_time));
      if (const auto* d = std::get_if<Displacement>(&sample.payload)) {
        add(d->x, d->y, d->covariance.xx, d->covariance.xy, d->covariance.yy, d->features, d->health, d->valid);
        add_region(d->region);
      } else if (const auto* motion = std::get_if<ImageMotion>(&sample.payload)) {
        for (const ImageMotion::Point& p : motion->points) add(p.x, p.y, p.dx, p.dy, p.target, p.good);
        for (const ImageMotion::Target& target : motion->targets) {
          all += target.name;
          add(target.health, target.valid);
          add_region(target.region);
        }
      }
    }
    return all;
  }

  StreamTable streams;
  StreamId image = streams.add({.topic = "/camera0/image", .kind = "frame", .device = "camera0"});
  StreamId operator_stream = streams.add({.topic = "/operator", .kind = "operator_action"});
  Collector collected;
  int index = 0;
  CameraTracker tracker;
};

}  // namespace roseau::tracking::testing
