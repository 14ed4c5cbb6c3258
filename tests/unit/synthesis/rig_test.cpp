#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <map>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "core/wind_geometry.h"
#include "drivers/wire/make_decoder.h"
#include "synthesis/simulated_rig.h"

namespace roseau::synthesis {
namespace {

using std::chrono::milliseconds;

// Small pictures: what is tested here is what comes when.
Scene small_scene() {
  Scene scene;
  for (CameraScene& camera : scene.cameras) {
    camera.width_px = 128;
    camera.height_px = 96;
    camera.format = PixelFormat::mono8;
    camera.focal_length_px = 160;
  }
  return scene;
}

constexpr std::uint64_t kHashStart = 14695981039346656037U;

std::uint64_t hash_of(std::span<const std::byte> bytes, std::uint64_t hash = kHashStart) {
  for (const std::byte byte : bytes) hash = (hash ^ static_cast<std::uint64_t>(byte)) * 1099511628211U;
  return hash;
}

template <class T>
std::uint64_t hash_of_value(const T& value, std::uint64_t hash) {
  return hash_of(std::as_bytes(std::span(&value, 1)), hash);
}

// Keeps all but the frames' pixels, of which it keeps a hash.
struct Collector : SampleSink {
  bool receive(Sample sample) override {
    if (auto* frame = std::get_if<Frame>(&sample.payload)) {
      pixel_hashes.push_back(hash_of(frame->bytes()));
      frame->pixels = {};
    }
    samples.push_back(std::move(sample));
    return true;
  }
  void flush() override { flushed = true; }

  std::vector<const Sample*> of(const StreamTable& streams, const std::string& topic) const {
    const auto id = streams.find(topic);
    EXPECT_TRUE(id.has_value()) << topic;
    std::vector<const Sample*> found;
    for (const Sample& sample : samples) {
      if (sample.header.stream == id) found.push_back(&sample);
    }
    return found;
  }

  std::vector<Sample> samples;
  std::vector<std::uint64_t> pixel_hashes;
  bool flushed = false;
};

struct Session {
  StreamTable streams;
  Collector collector;
};

std::unique_ptr<Session> simulated(const Scene& scene, double seconds) {
  auto session = std::make_unique<Session>();
  const auto done = simulate(scene, seconds, session->streams, session->collector);
  EXPECT_TRUE(done);
  EXPECT_TRUE(session->collector.flushed);
  return session;
}

std::vector<const Sample*> of(const Session& session, const std::string& topic) {
  return session.collector.of(session.streams, topic);
}

template <class T>
const T& payload(const Sample* sample) {
  return std::get<T>(sample->payload);
}

TEST(SimulatedRig, SendsEveryStreamAtItsRateInOrderOfArrival) {
  const auto session = simulated(small_scene(), 5);
  EXPECT_NEAR(static_cast<double>(of(*session, "/camera0/image").size()), 150, 1);
  EXPECT_NEAR(static_cast<double>(of(*session, "/camera1/image").size()), 150, 1);
  EXPECT_EQ(of(*session, "/camera0/calibration").size(), 5U);
  EXPECT_EQ(of(*session, "/truth/wind").size(), 100U);
  EXPECT_EQ(of(*session, "/truth/sonic/wind").size(), 100U);
  EXPECT_EQ(of(*session, "/truth/camera0/target/branch/displacement").size(), 150U);
  EXPECT_EQ(of(*session, "/truth/camera1/target/branch/force").size(), 150U);
  EXPECT_EQ(of(*session, "/truth/target/branch/identification").size(), 1U);
  const auto& samples = session->collector.samples;
  EXPECT_TRUE(std::ranges::is_sorted(samples, {}, [](const Sample& sample) { return sample.header.arrival_time; }));
  for (const Sample& sample : samples) EXPECT_LE(sample.header.sample_time, sample.header.arrival_time);
}

TEST(SimulatedRig, TheSameSceneGivesTheSameBytes) {
  const auto digest = [](const Scene& scene) {
    const auto session = simulated(scene, 2);
    std::uint64_t hash = kHashStart;
    for (const Sample& sample : session->collector.samples) {
      hash = hash_of_value(sample.header.arrival_time, hash_of_value(sample.header.sample_time, hash));
      if (const auto* raw = std::get_if<RawBytes>(&sample.payload)) hash = hash_of(raw->bytes(), hash);
      if (const auto* truth = std::get_if<Displacement>(&sample.payload)) hash = hash_of_value(truth->x, hash);
    }
    for (const std::uint64_t pixels : session->collector.pixel_hashes) hash = hash_of_value(pixels, hash);
    return hash;
  };
  Scene scene = small_scene();
  const std::uint64_t once = digest(scene);
  EXPECT_EQ(digest(scene), once);
  scene.seed = 2;
  EXPECT_NE(digest(scene), once);
}

TEST(SimulatedRig, DevicesReadOneByOneSendTheSame) {
  const Scene scene = small_scene();
  const auto merged = simulated(scene, 2);
  StreamTable streams;
  for (const auto& source : SimulatedRig(scene).sources(2)) {
    Collector alone;
    ASSERT_TRUE(source->open(streams));
    EXPECT_FALSE(source->is_live());
    while (*source->read(alone, milliseconds(10)) != ReadStatus::finished) {
    }
    ASSERT_FALSE(alone.samples.empty());
    std::map<std::string, std::vector<const Sample*>> by_topic;
    for (const Sample& sample : alone.samples) by_topic[streams.info(sample.header.stream).topic].push_back(&sample);
    for (const auto& [topic, samples] : by_topic) {
      const auto expected = of(*merged, topic);
      ASSERT_EQ(samples.size(), expected.size()) << topic;
      for (std::size_t i = 0; i < samples.size(); ++i) {
        EXPECT_EQ(samples[i]->header.arrival_time, expected[i]->header.arrival_time);
        EXPECT_EQ(samples[i]->header.sequence, expected[i]->header.sequence);
      }
    }
  }
}

TEST(SimulatedRig, DevicesReadInThreadsOfTheirOwnSendTheSame) {
  const Scene scene = small_scene();
  const auto merged = simulated(scene, 1);
  StreamTable streams;
  auto sources = SimulatedRig(scene).sources(1);
  std::vector<Collector> collectors(sources.size());
  {
    std::vector<std::jthread> threads;
    for (std::size_t i = 0; i < sources.size(); ++i) {
      threads.emplace_back([&, i] {
        ASSERT_TRUE(sources[i]->open(streams));
        while (*sources[i]->read(collectors[i], milliseconds(10)) != ReadStatus::finished) {
        }
      });
    }
  }
  std::size_t samples = 0;
  std::vector<std::uint64_t> pixels;
  for (const Collector& collector : collectors) {
    samples += collector.samples.size();
    pixels.insert(pixels.end(), collector.pixel_hashes.begin(), collector.pixel_hashes.end());
  }
  EXPECT_EQ(samples, merged->collector.samples.size());
  EXPECT_THAT(pixels, ::testing::UnorderedElementsAreArray(merged->collector.pixel_hashes));
}

TEST(SimulatedRig, TheSonicsBytesDecodeToTheTruthAtItsPlace) {
  Scene scene = small_scene();
  scene.sonic.north_offset_deg = 40;
  scene.sonic.timing.jitter_s = 0.002;
  scene.sonic.averages_paths = false;  // truth is at a point
  const auto session = simulated(scene, 20);
  Collector decoded;
  const auto decoder = wire::make_decoder(session->streams.info(*session->streams.find("/sonic/raw")), session->streams);
  ASSERT_TRUE(decoder);
  const auto pieces = of(*session, "/sonic/raw");
  for (const Sample* piece : pieces) decoder->decode(*piece, decoded);
  EXPECT_GT(pieces.size(), decoded.samples.size());  // some records came in two pieces
  EXPECT_EQ(decoder->counters().bad_records, 0U);
  EXPECT_EQ(decoder->counters().skipped_bytes, 0U);

  const auto truth = of(*session, "/truth/sonic/wind");  // at the same times: no clock error, same rate
  ASSERT_NEAR(static_cast<double>(decoded.samples.size()), 400, 3);
  double error2 = 0;
  double late_s = 0;
  for (std::size_t i = 0; i < decoded.samples.size(); ++i) {
    const auto& measured = payload<WindSample>(&decoded.samples[i]);
    const auto& air = payload<WindSample>(truth[i]);
    error2 += std::pow(measured.u_mps - air.u_mps, 2) + std::pow(measured.v_mps - air.v_mps, 2) +
              std::pow(measured.w_mps - air.w_mps, 2);
    EXPECT_NEAR(measured.sonic_temperature_celsius, air.sonic_temperature_celsius, 0.12);
    EXPECT_NEAR(measured.speed_of_sound_mps, air.speed_of_sound_mps, 0.02);
    const double late = to_seconds(decoded.samples[i].header.sample_time - truth[i]->header.sample_time);
    EXPECT_GT(late, -1e-6);
    late_s += late;
  }
  const double rms = std::sqrt(error2 / (3 * static_cast<double>(decoded.samples.size())));
  EXPECT_NEAR(rms, std::hypot(0.02, 0.01 / std::sqrt(12)), 0.002);                   // its noise and its rounding
  EXPECT_NEAR(late_s / static_cast<double>(decoded.samples.size()), 0.002, 0.0005);  // its jitter
}

TEST(SimulatedRig, TheSonicShowsTheWindFromWhereItComes) {
  Scene scene = small_scene();
  scene.wind.turbulence_intensity = 0;
  scene.wind.direction_from_deg = 240;
  scene.sonic.north_offset_deg = 235;
  const auto session = simulated(scene, 1);
  for (const Sample* sample : of(*session, "/truth/wind")) {
    const auto& air = payload<WindSample>(sample);
    EXPECT_NEAR(wind_direction_deg(air.u_mps, air.v_mps, 235), 240, 1e-3);
    EXPECT_NEAR(std::hypot(air.u_mps, air.v_mps), 4, 1e-9);
    EXPECT_NEAR(air.w_mps, 0, 1e-9);
  }
}

TEST(SimulatedRig, SerialBytesNeverOverlapOnTheLine) {
  Scene scene = small_scene();
  scene.sonic.baud = 10600;  // just fast enough: jitter makes records queue up
  scene.sonic.timing.jitter_s = 0.02;
  const auto session = simulated(scene, 20);
  HostTime free{};
  bool queued = false;
  for (const Sample* sample : of(*session, "/sonic/raw")) {
    const auto& raw = payload<RawBytes>(sample);
    EXPECT_GE(sample->header.arrival_time, free);
    queued = queued || sample->header.arrival_time == free;
    free = sample->header.arrival_time + raw.byte_time * raw.size;
  }
  EXPECT_TRUE(queued);
}

TEST(SimulatedRig, AFastClockSamplesMoreOften) {
  Scene scene = small_scene();
  scene.sonic.timing = {.frequency_offset_ppm = 5000, .latency_s = 0.05};
  scene.sonic.split_probability = 0;
  const auto session = simulated(scene, 20);
  const auto pieces = of(*session, "/sonic/raw");
  const double span_s = to_seconds(pieces.back()->header.arrival_time - pieces.front()->header.arrival_time);
  EXPECT_NEAR(span_s / static_cast<double>(pieces.size() - 1), 0.05 / 1.005, 1e-8);
}

TEST(SimulatedRig, TruthIsTheMotionThatThePicturesShow) {
  const Scene scene = small_scene();
  const auto session = simulated(scene, 3);
  const auto frames = of(*session, "/camera1/image");
  const auto truth = of(*session, "/truth/camera1/target/branch/displacement");
  double sum = 0;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    EXPECT_EQ(frames[i]->header.sample_time, truth[i]->header.sample_time);
    EXPECT_EQ(frames[i]->header.sequence, i);
    const auto& moved = payload<Displacement>(truth[i]);
    sum += moved.x;
    const ImageRect rest = target_region(scene, scene.cameras[1], 0);
    EXPECT_NEAR(moved.region.x - rest.x, moved.x, 0.02 * std::abs(moved.x) + 1e-9);
  }
  EXPECT_GT(sum / static_cast<double>(frames.size()), 0.5);  // to the right, with the wind
}

TEST(SimulatedRig, TrueForceObeysTheOscillatorsEquation) {
  Scene scene = small_scene();
  for (CameraScene& camera : scene.cameras) camera.rate_hz = 200;
  const auto session = simulated(scene, 3);
  const auto moved = of(*session, "/truth/camera0/target/branch/displacement");
  const auto force = of(*session, "/truth/camera0/target/branch/force");
  const auto& identified = payload<Identification>(of(*session, "/truth/target/branch/identification").front());
  const double w0 = 2 * M_PI * identified.natural_frequency_hz;
  const double gamma = 2 * identified.damping_ratio * w0;
  const double dt = 1 / 200.0;
  const auto x = [&](std::size_t i) {
    const auto& d = payload<Displacement>(moved[i]);
    return d.x * identified.axis.x + d.y * identified.axis.y;
  };
  double error2 = 0;
  double force2 = 0;
  for (std::size_t i = 1; i + 1 < moved.size(); ++i) {
    const double left =
        (x(i + 1) - 2 * x(i) + x(i - 1)) / (dt * dt) + gamma * (x(i + 1) - x(i - 1)) / (2 * dt) + w0 * w0 * x(i);
    const double right = payload<WindEstimate>(force[i]).force_per_mass;
    error2 += (left - right) * (left - right);
    force2 += right * right;
  }
  EXPECT_LT(std::sqrt(error2 / force2), 0.01);
}

TEST(SimulatedRig, TruthCanBeLeftOut) {
  Scene scene = small_scene();
  scene.truth.enabled = false;
  const auto session = simulated(scene, 1);
  EXPECT_FALSE(session->streams.find("/truth/wind").has_value());
  EXPECT_TRUE(session->streams.find("/sonic/raw").has_value());
}

// ---------------------------------------------------------------------------------------------------------------------
// Live, against a clock of the test's own.

struct FakeClock {
  HostTime now = host_time_from_ns(5'000'000'000);
  Pacing pacing() {
    return {[this] { return now; }, [this](Duration duration) { now += duration; }};
  }
};

std::unique_ptr<SampleSource> live(FakeClock& clock, const std::string& name) {
  for (auto& source : SimulatedRig(small_scene()).live_sources(clock.pacing())) {
    if (source->name() == name) return std::move(source);
  }
  return nullptr;
}

TEST(LiveRig, SamplesComeWhenTheyAreDueAndNotBefore) {
  for (const std::string name : {"camera0", "sonic", "truth"}) {
    FakeClock clock;
    const auto source = live(clock, name);
    ASSERT_TRUE(source) << name;
    EXPECT_TRUE(source->is_live());
    StreamTable streams;
    ASSERT_TRUE(source->open(streams));
    Collector collector;
    const HostTime end = clock.now + std::chrono::seconds(2);
    while (clock.now < end) {
      const std::size_t before = collector.samples.size();
      const auto status = source->read(collector, milliseconds(10));
      ASSERT_TRUE(status);
      EXPECT_EQ(*status == ReadStatus::more, collector.samples.size() > before);
      for (std::size_t i = before; i < collector.samples.size(); ++i) {
        EXPECT_LE(collector.samples[i].header.arrival_time, clock.now);
        EXPECT_GT(collector.samples[i].header.arrival_time, clock.now - milliseconds(20));
      }
    }
    EXPECT_GT(collector.samples.size(), 38U) << name;
  }
}

TEST(LiveRig, ReadKeepsItsTimeout) {
  FakeClock clock;
  const auto source = live(clock, "camera0");
  StreamTable streams;
  ASSERT_TRUE(source->open(streams));
  Collector collector;
  const HostTime before = clock.now;
  EXPECT_EQ(*source->read(collector, milliseconds(5)), ReadStatus::idle);
  EXPECT_EQ(clock.now - before, milliseconds(5));
}

std::vector<std::uint32_t> frame_numbers(const Collector& collector) {
  std::vector<std::uint32_t> numbers;
  for (const Sample& sample : collector.samples) {
    if (sample.kind() == SampleKind::frame) numbers.push_back(sample.header.sequence);
  }
  return numbers;
}

TEST(LiveRig, AStalledReaderLosesFramesButNoBytes) {
  for (const std::string name : {"camera0", "sonic"}) {
    FakeClock clock;
    const auto source = live(clock, name);
    StreamTable streams;
    ASSERT_TRUE(source->open(streams));
    Collector collector;
    for (int i = 0; i < 100; ++i) (void)*source->read(collector, milliseconds(10));
    clock.now += std::chrono::seconds(3);
    for (int i = 0; i < 400; ++i) (void)*source->read(collector, milliseconds(10));
    if (name == "camera0") {
      const auto numbers = frame_numbers(collector);
      std::uint32_t widest = 0;
      for (std::size_t i = 1; i < numbers.size(); ++i) widest = std::max(widest, numbers[i] - numbers[i - 1]);
      EXPECT_NEAR(widest, 90, 3);
    } else {
      for (std::size_t i = 0; i < collector.samples.size(); ++i) EXPECT_EQ(collector.samples[i].header.sequence, i);
      EXPECT_GT(collector.samples.size(), 130U);
    }
  }
}

TEST(LiveRig, AReopenedCameraGoesOnWhereTheSceneIs) {
  FakeClock clock;
  const auto source = live(clock, "camera0");
  StreamTable streams;
  ASSERT_TRUE(source->open(streams));
  source->close();
  clock.now += std::chrono::seconds(10);
  ASSERT_TRUE(source->open(streams));
  Collector collector;
  while (collector.samples.empty()) ASSERT_TRUE(source->read(collector, milliseconds(10)));
  EXPECT_EQ(collector.samples.front().kind(), SampleKind::camera_calibration);
  EXPECT_NEAR(frame_numbers(collector).front(), 300, 2);
}

// A sink that never lets go of a frame.
struct Hoarder : SampleSink {
  bool receive(Sample sample) override {
    samples.push_back(std::move(sample));
    return true;
  }
  std::vector<Sample> samples;
};

TEST(LiveRig, WithoutAFreeBufferFramesAreLostAndCounted) {
  FakeClock clock;
  const auto source = live(clock, "camera1");
  StreamTable streams;
  ASSERT_TRUE(source->open(streams));
  Hoarder hoarder;
  const HostTime end = clock.now + std::chrono::seconds(3);
  for (int reads = 0; clock.now < end; ++reads) {
    ASSERT_LT(reads, 2000) << "a frame without a buffer was not given up";
    ASSERT_TRUE(source->read(hoarder, milliseconds(10)));
  }
  const std::size_t held = hoarder.samples.size();
  EXPECT_LT(held, 70U);
  hoarder.samples.clear();
  while (hoarder.samples.empty()) ASSERT_TRUE(source->read(hoarder, milliseconds(10)));
  EXPECT_NEAR(hoarder.samples.back().header.sequence, 90, 2);
}

TEST(SimulatedRig, WaitsForAFreeBufferWhenNotLive) {
  const auto source = SimulatedRig(small_scene()).merged_source(60);
  StreamTable streams;
  ASSERT_TRUE(source->open(streams));
  Hoarder hoarder;
  while (*source->read(hoarder, milliseconds(1)) == ReadStatus::more) {
  }
  const auto last = hoarder.samples.back().header.arrival_time;
  hoarder.samples.clear();
  ASSERT_EQ(*source->read(hoarder, milliseconds(1)), ReadStatus::more);
  EXPECT_LT(hoarder.samples.front().header.arrival_time - last, milliseconds(40));  // nothing was lost meanwhile
}

}  // namespace
}  // namespace roseau::synthesis
