// The real drivers against instruments of the simulated field, through pseudo terminals and sockets of this machine. The
// instruments' clock runs ten times too fast, so that much happens in little time.
#include "replay/emulator.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <thread>

#include "drivers/led_sync/led_board_source.h"
#include "drivers/link/link_spec.h"
#include "drivers/link/posix.h"
#include "drivers/link/pty_stream.h"
#include "drivers/link/tcp_stream.h"
#include "drivers/magnetic_tracker/magnetic_tracker_source.h"
#include "drivers/sonic/sonic_source.h"
#include "drivers/wire/make_decoder.h"
#include "synthesis/instruments/speaking_instrument.h"
#include "tests/support/temporary_folder.h"

namespace roseau::replay {
namespace {

using std::chrono::milliseconds;

constexpr int kSpeed = 10;

struct Field final : synthesis::Surroundings {
  Vec3 wind_mps(const Vec3&, double) const override { return {-3, -1.5, 0.25}; }
  synthesis::StationPlace station_place(std::size_t station, double) const override {
    return {{0.1 * static_cast<double>(station), 0.2, 0.3}, {1, 0, 0, 0}};
  }
};

std::unique_ptr<EmulatedInstrument> a_sonic(std::vector<double> pulls_s = {}) {
  synthesis::SonicOptions options;
  options.noise_mps = 0;
  options.timing = {.jitter_s = 0.001};
  options.timing.cable_pulls_s = std::move(pulls_s);
  return make_speaking(std::make_shared<synthesis::Sonic>("sonic", options, 1, std::make_shared<Field>()), 1);
}

std::unique_ptr<EmulatedInstrument> a_tracker() {
  synthesis::MagneticTrackerOptions options;
  options.source_position_in_world_m = {0, 0, 0};
  auto tracker = synthesis::MagneticTracker::make("tracker", options, 1, std::make_shared<Field>());
  return make_speaking(*tracker, 1);
}

std::unique_ptr<EmulatedInstrument> an_led_board() {
  return make_speaking(std::make_shared<synthesis::LedBoard>("led_board", synthesis::LedBoardOptions{}, 1), 1);
}

/// An emulator in a thread of its own, on a link that the other side can name.
class RunningEmulator {
 public:
  RunningEmulator(const std::string& kind, std::unique_ptr<EmulatedInstrument> instrument) {
    const HostTime start = link::monotonic_now();
    const auto fast = [start] { return start + kSpeed * (link::monotonic_now() - start); };
    std::unique_ptr<link::ByteStream> stream;
    link::TcpListenStream* listener = nullptr;
    if (kind == "pty") {
      const std::string path = folder_.path() / "port";
      stream = std::make_unique<link::PtyStream>(path);
      link_ = "serial:" + path + "?baud=115200";
    } else {
      auto tcp = std::make_unique<link::TcpListenStream>("127.0.0.1", 0, Duration{0});
      listener = tcp.get();
      stream = std::move(tcp);
    }
    emulator_ = std::make_unique<Emulator>(std::move(stream), std::move(instrument), start, fast);
    const auto opened = emulator_->open();
    EXPECT_TRUE(opened) << (opened ? "" : opened.error().message);
    if (listener != nullptr) link_ = "tcp://127.0.0.1:" + std::to_string(listener->port());
    thread_ = std::jthread([this](const std::stop_token& stop) {
      while (!stop.stop_requested()) {
        const auto stepped = emulator_->step(milliseconds(20));
        EXPECT_TRUE(stepped) << (stepped ? "" : stepped.error().message);
      }
    });
  }

  std::unique_ptr<link::ByteStream> connect() const {
    auto stream = link::make_byte_stream(link_);
    EXPECT_TRUE(stream);
    return std::move(*stream);
  }
  void stop() {
    thread_.request_stop();
    thread_.join();
  }
  const Emulator& emulator() const { return *emulator_; }

 private:
  testing::TemporaryFolder folder_;
  std::string link_;
  std::unique_ptr<Emulator> emulator_;
  std::jthread thread_;
};

struct Collector : SampleSink {
  bool receive(Sample sample) override {
    samples.push_back(std::move(sample));
    return true;
  }
  std::vector<Sample> samples;
};

struct Conversation {
  std::vector<Sample> samples;
  DecoderCounters counters;
  StreamTable streams;
};

/// Reads and decodes until that many samples have come, or far too much time has passed.
std::unique_ptr<Conversation> listen(SampleSource& source, std::size_t samples) {
  auto conversation = std::make_unique<Conversation>();
  const auto opened = source.open(conversation->streams);
  EXPECT_TRUE(opened) << (opened ? "" : opened.error().message);
  const auto raw = conversation->streams.find("/" + source.name() + "/raw");
  const auto decoder = wire::make_decoder(conversation->streams.info(*raw), conversation->streams);
  Collector decoded;
  for (int round = 0; round < 2000 && decoded.samples.size() < samples; ++round) {
    Collector pieces;
    const auto status = source.read(pieces, milliseconds(10));
    EXPECT_TRUE(status) << (status ? "" : status.error().message);
    for (const Sample& piece : pieces.samples) decoder->decode(piece, decoded);
  }
  source.close();
  EXPECT_GE(decoded.samples.size(), samples);
  conversation->samples = std::move(decoded.samples);
  conversation->counters = decoder->counters();
  return conversation;
}

class EmulatorTest : public ::testing::TestWithParam<std::string> {};
INSTANTIATE_TEST_SUITE_P(Links, EmulatorTest, ::testing::Values("pty", "tcp"), [](const auto& link) { return link.param; });

TEST_P(EmulatorTest, TheSonicsDriverHearsTheWind) {
  RunningEmulator running(GetParam(), a_sonic());
  sonic::SonicSource source({.anemometer = {.rate_hz = 20}}, running.connect());
  const auto heard = listen(source, 30);
  running.stop();
  EXPECT_EQ(heard->counters.bad_records, 0U);
  EXPECT_EQ(heard->counters.skipped_bytes, 0U);
  for (const Sample& sample : heard->samples) {
    const auto& wind = std::get<WindSample>(sample.payload);
    EXPECT_NEAR(wind.u_mps, -1.5, 0.0051);
    EXPECT_NEAR(wind.v_mps, 3, 0.0051);
  }
}

TEST_P(EmulatorTest, TheTrackersDriverSetsItUpAndHearsItsStations) {
  RunningEmulator running(GetParam(), a_tracker());
  magnetic_tracker::MagneticTrackerSource source({}, running.connect());
  const auto heard = listen(source, 300);
  running.stop();
  EXPECT_EQ(heard->counters.bad_records, 0U);
  EXPECT_EQ(heard->counters.skipped_bytes, 0U);
  EXPECT_EQ(heard->counters.text_lines, 2U) << "its status, before and after";
  std::array<int, 5> of_station{};
  for (const Sample& sample : heard->samples) {
    const auto& pose = std::get<StationPose>(sample.payload);
    ++of_station.at(pose.station);
    EXPECT_NEAR(pose.position_in_source_m.x, 0.1 * pose.station, 0.002);
    EXPECT_NEAR(pose.position_in_source_m.z, 0.3, 0.002);
  }
  for (int station = 1; station <= 4; ++station) EXPECT_NEAR(of_station.at(static_cast<std::size_t>(station)), 75, 6);
  EXPECT_GT(running.emulator().counters().bytes_received, 40U);
}

TEST_P(EmulatorTest, TheTrackersDriverMayWantTextAndInches) {
  RunningEmulator running(GetParam(), a_tracker());
  magnetic_tracker::MagneticTrackerOptions options;
  options.tracker.stations = {1, 2, 3, 4};
  options.tracker.is_binary = false;
  options.tracker.unit = wire::FastrakUnit::inch;
  options.tracker.layout = wire::default_fastrak_layout();
  magnetic_tracker::MagneticTrackerSource source(options, running.connect());
  const auto heard = listen(source, 100);
  running.stop();
  EXPECT_EQ(heard->counters.bad_records, 0U);
  for (const Sample& sample : heard->samples) {
    const auto& pose = std::get<StationPose>(sample.payload);
    EXPECT_NEAR(pose.position_in_source_m.x, 0.1 * pose.station, 0.002);
  }
}

TEST_P(EmulatorTest, TheBoardsDriverHearsItsTime) {
  RunningEmulator running(GetParam(), an_led_board());
  led_sync::LedBoardSource source({}, running.connect());
  const auto heard = listen(source, 10);
  running.stop();
  EXPECT_EQ(heard->counters.bad_records, 0U);
  EXPECT_EQ(heard->counters.skipped_bytes, 0U);
  EXPECT_EQ(heard->counters.text_lines, 2U) << "version and tick";
  for (std::size_t i = 1; i < heard->samples.size(); ++i) {
    EXPECT_EQ(*heard->samples[i].header.device_time - *heard->samples[i - 1].header.device_time, milliseconds(128));
  }
}

TEST_P(EmulatorTest, ListenersComeAndGo) {
  RunningEmulator running(GetParam(), a_tracker());
  for (int visit = 0; visit < 3; ++visit) {
    magnetic_tracker::MagneticTrackerSource source({}, running.connect());
    const auto heard = listen(source, 40);
    // The run before left it sending: what was on its way when the driver came may be cut off, nothing else.
    EXPECT_LE(heard->counters.bad_records, 1U) << visit;
  }
  running.stop();
}

TEST_P(EmulatorTest, APulledCableIsALostLinkAndComesBack) {
  RunningEmulator running(GetParam(), a_sonic({1, 3}));  // a tenth of that in real time
  StreamTable streams;
  sonic::SonicSource source({}, running.connect());
  ASSERT_TRUE(source.open(streams));
  Collector pieces;
  std::optional<Error> lost;
  for (int round = 0; round < 2000 && !lost; ++round) {
    const auto status = source.read(pieces, milliseconds(10));
    if (!status) lost = status.error();
  }
  ASSERT_TRUE(lost);
  EXPECT_EQ(lost->code, ErrorCode::disconnected);
  source.close();
  bool is_back = false;
  for (int round = 0; round < 500 && !is_back; ++round) {
    std::this_thread::sleep_for(milliseconds(5));
    is_back = source.open(streams).has_value();
  }
  ASSERT_TRUE(is_back);
  const std::size_t before = pieces.samples.size();
  for (int round = 0; round < 500 && pieces.samples.size() == before; ++round) {
    ASSERT_TRUE(source.read(pieces, milliseconds(10)));
  }
  EXPECT_GT(pieces.samples.size(), before);
  source.close();
  running.stop();
}

TEST(Emulator, ALinkThatCannotBeOpenedIsSaid) {
  Emulator emulator(std::make_unique<link::TcpListenStream>("256.1.1.1", 0, Duration{0}), a_sonic(), {}, link::monotonic_now);
  EXPECT_FALSE(emulator.open());
}

}  // namespace
}  // namespace roseau::replay
