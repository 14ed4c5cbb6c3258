// Surroundings that tests know in closed form, and what a device sends into them.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "core/decoder.h"
#include "core/stream.h"
#include "drivers/wire/make_decoder.h"
#include "synthesis/instruments/simulated_device.h"
#include "synthesis/instruments/surroundings.h"

namespace roseau::synthesis {

struct TestField final : Surroundings {
  std::function<Vec3(const Vec3&, double)> wind = [](const Vec3&, double) { return Vec3{}; };
  std::function<StationPlace(std::size_t, double)> place = [](std::size_t, double) { return StationPlace{}; };

  Vec3 wind_mps(const Vec3& point, double time_s) const override { return wind(point, time_s); }
  StationPlace station_place(std::size_t station, double time_s) const override { return place(station, time_s); }
};

struct CollectorSink : SampleSink {
  bool receive(Sample sample) override {
    samples.push_back(std::move(sample));
    return true;
  }
  std::vector<Sample> samples;
};

inline constexpr HostTime kSceneStart = host_time_from_ns(1'000'000'000);

/// Everything that arrives in the first `seconds`.
inline std::vector<Sample> play(SimulatedDevice& device, double seconds, StreamTable& streams) {
  CollectorSink sink;
  device.declare(streams);
  while (device.next().arrival < from_seconds(seconds)) device.produce(kSceneStart, sink);
  return std::move(sink.samples);
}

struct Decoded {
  StreamTable streams;
  std::vector<Sample> samples;
  DecoderCounters counters;

  std::string topic(const Sample& sample) const { return streams.info(sample.header.stream).topic; }
};

/// The same through the decoder that the stream's metadata names.
inline std::unique_ptr<Decoded> play_and_decode(SimulatedDevice& device, double seconds) {
  auto decoded = std::make_unique<Decoded>();
  const auto raw = play(device, seconds, decoded->streams);
  const auto decoder = wire::make_decoder(decoded->streams.info(raw.front().header.stream), decoded->streams);
  CollectorSink sink;
  for (const Sample& sample : raw) decoder->decode(sample, sink);
  decoded->samples = std::move(sink.samples);
  decoded->counters = decoder->counters();
  return decoded;
}

}  // namespace roseau::synthesis
