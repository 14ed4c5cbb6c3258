#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <map>
#include <memory>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "core/wind_geometry.h"
#include "drivers/wire/make_decoder.h"
#include "synthesis/instruments/rotation.h"
#include "synthesis/rig/world.h"
#include "synthesis/simulated_rig.h"

namespace roseau::synthesis {
namespace {

using std::chrono::milliseconds;

// A pole and small pictures: what is tested here is what comes when.
Scene small_scene() {
  Scene scene;
  scene.tree.kind = "cantilever";
  scene.tree.cantilever = {
      .length_m = 4, .start_radius_m = 0.022, .end_radius_m = 0.022, .segment_count = 8, .board_leaves = 4};
  scene.mechanics.mode_count = 6;
  scene.targets = {{.name = "branch", .near_in_world_m = {0, 0, 4}, .width_m = 0.3, .height_m = 0.3}};
  scene.balls.near_in_world_m = {0, 0, 2, 0, 0, 3.5};
  scene.wind.turbulence.period_s = 256;
  for (CameraScene& camera : scene.cameras) {
    camera.width_px = 128;
    camera.height_px = 96;
    camera.format = PixelFormat::mono8;
    camera.focal_length_px = 200;
    camera.look_at_in_world_m.z = 2.5;
  }
  return scene;
}

SimulatedRig rig_of(const Scene& scene) {
  auto rig = SimulatedRig::create(scene);
  if (!rig) throw std::runtime_error(rig.error().message);
  return std::move(*rig);
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
  const auto done = simulate(rig_of(scene), seconds, session->streams, session->collector);
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
  for (const auto& source : rig_of(scene).sources(2)) {
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
  auto sources = rig_of(scene).sources(1);
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
  scene.wind.turbulence.turbulence_intensity = 0;
  scene.wind.turbulence.direction_from_deg = 240;
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
  const auto world = *World::build(scene);
  const auto frames = of(*session, "/camera1/image");
  const auto truth = of(*session, "/truth/camera1/target/branch/displacement");
  double sum = 0;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    EXPECT_EQ(frames[i]->header.sample_time, truth[i]->header.sample_time);
    EXPECT_EQ(frames[i]->header.sequence, i);
    const auto& moved = payload<Displacement>(truth[i]);
    sum += moved.x;
    const ImageRect rest = world->target_region(world->targets().front(), 1, {});
    EXPECT_NEAR(moved.region.x - rest.x, moved.x, 0.02 * std::abs(moved.x) + 0.01);
  }
  EXPECT_GT(sum / static_cast<double>(frames.size()), 0.1);  // to the right, with the wind
}

TEST(SimulatedRig, TrueForceObeysTheOscillatorsEquation) {
  Scene scene = small_scene();
  scene.mechanics.mode_count = 1;
  scene.drag.relative_velocity = false;  // else the air's damping is a part of the force
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

TEST(SimulatedRig, MarkersAndStationsAreWhereTheTreeIs) {
  const Scene scene = small_scene();
  const auto session = simulated(scene, 3);
  const auto world = *World::build(scene);
  for (const Sample* sample : of(*session, "/truth/balls")) {
    const auto& balls = payload<MarkerPositions>(sample);
    ASSERT_EQ(balls.markers.size(), 2U);
    EXPECT_EQ(balls.markers[1].name, "ball2");
    const double time_s = to_seconds(sample->header.sample_time - SimulatedRig::kSimulatedStart);
    EXPECT_NEAR(balls.markers[1].position_m.x, world->station_place(2, time_s).position_in_world_m.x, 1e-9);
    EXPECT_NEAR(balls.markers[1].position_m.z, 3.5, 0.05);
  }
  // The tracker's bytes decode to the poses it truly has, but for its noise.
  Collector decoded;
  const auto decoder = wire::make_decoder(session->streams.info(*session->streams.find("/tracker/raw")), session->streams);
  ASSERT_TRUE(decoder);
  for (const Sample* piece : of(*session, "/tracker/raw")) decoder->decode(*piece, decoded);
  const auto poses = decoded.of(session->streams, "/tracker/station1/pose");
  const auto truth = of(*session, "/truth/tracker/station1/pose");
  ASSERT_NEAR(static_cast<double>(poses.size()), 180, 2);
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const Vec3 error =
        payload<StationPose>(poses[i]).position_in_source_m - payload<StationPose>(truth[i]).position_in_source_m;
    EXPECT_LT(length(error), 0.2);
    EXPECT_NEAR(to_seconds(poses[i]->header.sample_time - truth[i]->header.sample_time), 0.0003, 0.003);
  }
}

TEST(SimulatedRig, ACameraWithAClockOfItsOwnSendsItsCounterAndLosesFrames) {
  Scene scene = small_scene();
  scene.cameras[0].stamps = "device";
  scene.cameras[0].timing.counter_offset_s = 1000;
  scene.cameras[0].timing.frequency_offset_ppm = 100;
  scene.cameras[0].timing.drop_probability = 0.1;
  scene.cameras[0].timing.cable_pulls_s = {2, 3};
  const auto session = simulated(scene, 5);
  const auto frames = of(*session, "/camera0/image");
  EXPECT_LT(frames.size(), 120U);
  EXPECT_GT(frames.size(), 80U);
  std::map<std::uint32_t, HostTime> midpoints;
  for (const Sample* sample : of(*session, "/truth/camera0/exposure"))
    midpoints[sample->header.sequence] = sample->header.sample_time;
  for (const Sample* frame : frames) {
    ASSERT_TRUE(frame->header.device_time);
    const double midpoint_s = to_seconds(midpoints.at(frame->header.sequence) - SimulatedRig::kSimulatedStart);
    EXPECT_NEAR(to_seconds(frame->header.device_time->time_since_epoch()), 1000 + midpoint_s * (1 + 1e-4), 1e-6);
    EXPECT_FALSE(midpoint_s > 2.001 && midpoint_s < 2.999);
  }
}

TEST(SimulatedRig, ScenesThatCannotBeAreRefusedBeforeTheyStart) {
  const auto message = [](const Scene& scene) {
    const auto rig = SimulatedRig::create(scene);
    return rig ? std::string("accepted") : rig.error().message;
  };
  Scene scene = small_scene();
  scene.mechanics.mode_count = 400;
  EXPECT_THAT(message(scene), ::testing::HasSubstr("48"));  // degrees of freedom of its eight free nodes
  scene = small_scene();
  scene.cameras.assign(8, scene.cameras.front());
  for (CameraScene& camera : scene.cameras) {
    camera.width_px = camera.height_px = 4096;
    camera.format = PixelFormat::bgr8;
  }
  EXPECT_THAT(message(scene), ::testing::HasSubstr("GB"));
  scene = small_scene();
  scene.wind.turbulence.strand_spacing_m = 0.05;
  scene.wind.turbulence.period_s = 20000;
  scene.tree.kind = "grown";
  EXPECT_THAT(message(scene), ::testing::HasSubstr("wind"));
  scene = small_scene();
  scene.mechanics.stepping = "semi_implicit";
  scene.mechanics.step_rate_hz = 20;
  EXPECT_THAT(message(scene), ::testing::HasSubstr("step"));
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
  for (auto& source : rig_of(small_scene()).live_sources(clock.pacing())) {
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
  const auto source = rig_of(small_scene()).merged_source(60);
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
