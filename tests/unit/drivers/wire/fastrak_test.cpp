// Golden bytes: the record forms of the maker's manual (OPM00PI002 Rev G pages 40, 64, 74); IEEE-754 bytes made with Python's
// struct, rotations with SciPy's Rotation (intrinsic ZYX).
#include "drivers/wire/fastrak.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <fstream>
#include <limits>
#include <numbers>
#include <random>

#include "drivers/wire/fastrak_decoder.h"
#include "drivers/wire/magnetic_tracker.h"
#include "drivers/wire/make_decoder.h"
#include "drivers/wire/rotations.h"
#include "tests/support/data.h"
#include "tests/unit/drivers/wire/fed_decoder.h"

namespace roseau::wire {
namespace {

using namespace std::string_literals;

const std::string kText = "01   12.34  -5.67   8.90 -45.00  10.25 179.99\r\n";
const std::string kBinary =
    "\x30\x31\x20\x00\x00\x48\x41\x00\x00\x70\xc0\x00\x00\x20\x42"
    "\x00\x00\x00\x3f\x00\x00\x00\xbf\x00\x00\x00\x3f\x00\x00\x00\x3f\x20"s;
const std::string kBinary4 =
    "\x30\x34\x20\x9a\x99\xfd\x41\x14\xae\x65\xc2\x9a\x19\xb0\x42"
    "\x5e\x83\x6c\x3f\x00\x00\x00\x00\x00\x00\x00\x00\x15\xef\xc3\x3e\x20"s;

FastrakLayout layout_of(std::string_view items) {
  auto layout = FastrakLayout::parse(items);
  EXPECT_TRUE(layout) << layout.error().message;
  return *layout;
}

void expect_rotation(const Quaternion& got, const Quaternion& expected, double tolerance) {
  // q and -q are one rotation.
  const double dot = got.w * expected.w + got.x * expected.x + got.y * expected.y + got.z * expected.z;
  EXPECT_NEAR(std::abs(dot), 1, tolerance);
}

TEST(FastrakRecord, TheMakersTextRecord) {
  ASSERT_EQ(kText.size(), 47U);
  const auto pose = parse_fastrak_text(kText, default_fastrak_layout(), FastrakUnit::inch);
  ASSERT_TRUE(pose);
  EXPECT_EQ(pose->station, 1);
  EXPECT_TRUE(pose->valid);
  EXPECT_EQ(pose->device_status, 0);
  EXPECT_DOUBLE_EQ(pose->position_in_source_m.x, 12.34 * 0.0254);
  EXPECT_DOUBLE_EQ(pose->position_in_source_m.y, -5.67 * 0.0254);
  EXPECT_DOUBLE_EQ(pose->position_in_source_m.z, 8.90 * 0.0254);
  expect_rotation(pose->source_from_station, {-0.0341043860, 0.9201890110, -0.3811463306, -0.0825623978}, 1e-9);
}

TEST(FastrakRecord, BinaryIsLittleEndianFloats) {
  ASSERT_EQ(kBinary.size(), 32U);
  const auto pose = parse_fastrak_binary(kBinary, quaternion_fastrak_layout(), FastrakUnit::centimetre);
  ASSERT_TRUE(pose);
  EXPECT_EQ(pose->station, 1);
  EXPECT_DOUBLE_EQ(pose->position_in_source_m.x, 0.125);
  EXPECT_DOUBLE_EQ(pose->position_in_source_m.y, -0.0375);
  EXPECT_DOUBLE_EQ(pose->position_in_source_m.z, 0.4);
  expect_rotation(pose->source_from_station, {0.5, -0.5, 0.5, 0.5}, 1e-12);
  const auto other = parse_fastrak_binary(kBinary4, quaternion_fastrak_layout(), FastrakUnit::centimetre);
  ASSERT_TRUE(other);
  EXPECT_EQ(other->station, 4);
  EXPECT_NEAR(other->position_in_source_m.y, -0.5742, 1e-7);
  expect_rotation(other->source_from_station, {std::cos(std::numbers::pi / 8), 0, 0, std::sin(std::numbers::pi / 8)}, 1e-7);
}

TEST(FastrakRecord, EncodesTheSameBytes) {
  const StationPose pose{.station = 1,
                         .position_in_source_m = {12.34 * 0.0254, -5.67 * 0.0254, 8.90 * 0.0254},
                         .source_from_station = quaternion_from_angles_deg(-45, 10.25, 179.99)};
  EXPECT_EQ(encode_fastrak(pose, {}), kText);
  const StationPose other{
      .station = 1, .position_in_source_m = {0.125, -0.0375, 0.4}, .source_from_station = {0.5, -0.5, 0.5, 0.5}};
  EXPECT_EQ(encode_fastrak(other, {quaternion_fastrak_layout(), true, FastrakUnit::centimetre}), kBinary);
}

TEST(FastrakRecord, FieldsMayTouch) {
  const std::string record = "02 -123.45-678.90-123.45-180.00 -90.00-180.00\r\n";
  const auto pose = parse_fastrak_text(record, default_fastrak_layout(), FastrakUnit::centimetre);
  EXPECT_FALSE(pose) << "6.8 m away is no record";
  const std::string near = "02 -123.45-178.90-123.45-180.00 -90.00-180.00\r\n";
  const auto touching = parse_fastrak_text(near, default_fastrak_layout(), FastrakUnit::centimetre);
  ASSERT_TRUE(touching);
  EXPECT_DOUBLE_EQ(touching->position_in_source_m.y, -1.789);
}

TEST(FastrakRecord, DirectionCosinesAreRowsOfTheMatrix) {
  // SciPy: Rotation.from_euler('ZYX', [30, -20, 100], degrees=True).as_matrix(), in the manual's Sx.xxxx.
  const auto layout = layout_of("2,5,6,7,1");
  const std::string record = "03    1.00   2.00   3.00 0.8138-0.2049 0.5438 0.4698-0.3188-0.8232 0.3420 0.9254-0.1632\r\n";
  ASSERT_EQ(record.size(), layout.text_bytes());
  const auto pose = parse_fastrak_text(record, layout, FastrakUnit::inch);
  ASSERT_TRUE(pose);
  expect_rotation(pose->source_from_station, {0.5770238281, 0.7575898247, 0.0874391963, 0.2923278062}, 1e-8);
  EXPECT_EQ(encode_fastrak(*pose, {layout}), record);
  auto reflected = record;
  for (std::size_t i = 24; i < 87; ++i) {
    if (reflected[i] == '-') {
      reflected[i] = ' ';
    } else if (reflected[i] == ' ') {
      reflected[i] = '-';
    }
  }
  EXPECT_FALSE(parse_fastrak_text(reflected, layout, FastrakUnit::inch)) << "a reflection is no rotation";
}

TEST(FastrakRecord, ExtendedPrecision) {
  const auto layout = layout_of("52,61,1");
  const std::string record =
      "01  1.23400E+01 -5.67000E+00  8.90000E-01  5.00000E-01 -5.00000E-01  5.00000E-01  5.00000E-01 \r\n";
  ASSERT_EQ(record.size(), layout.text_bytes());
  const auto pose = parse_fastrak_text(record, layout, FastrakUnit::centimetre);
  ASSERT_TRUE(pose);
  EXPECT_DOUBLE_EQ(pose->position_in_source_m.z, 0.0089);
  EXPECT_EQ(encode_fastrak(*pose, {layout, false, FastrakUnit::centimetre}), record);
}

TEST(FastrakRecord, EveryErrorLetterKeepsItsNumbers) {
  for (char letter = 'a'; letter <= 'y'; ++letter) {
    auto record = kText;
    record[2] = letter;
    const auto pose = parse_fastrak_text(record, default_fastrak_layout(), FastrakUnit::inch);
    ASSERT_TRUE(pose);
    EXPECT_FALSE(pose->valid);
    EXPECT_EQ(pose->device_status, letter);
    EXPECT_DOUBLE_EQ(pose->position_in_source_m.x, 12.34 * 0.0254);
    EXPECT_EQ(encode_fastrak(*pose, {}), record);
  }
}

TEST(FastrakRecord, WhatIsNoNumberIsNoRecord) {
  for (const std::string& x :
       {"    nan"s, "    inf"s, "*******"s, "1.2.3.4"s, "       "s, "      -"s, "  1e3  "s, "-  -1.0"s}) {
    auto record = kText;
    record.replace(3, 7, x);
    EXPECT_FALSE(parse_fastrak_text(record, default_fastrak_layout(), FastrakUnit::inch)) << x;
  }
  for (const float value : {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity(), 1e9F}) {
    auto record = kBinary;
    std::memcpy(record.data() + 7, &value, sizeof value);
    EXPECT_FALSE(parse_fastrak_binary(record, quaternion_fastrak_layout(), FastrakUnit::inch)) << value;
  }
  auto long_quaternion = kBinary;
  long_quaternion[18] = '\x40';
  EXPECT_FALSE(parse_fastrak_binary(long_quaternion, quaternion_fastrak_layout(), FastrakUnit::inch));
}

TEST(FastrakRecord, NegativeZeroAndSpacesBehindTheSignAreNumbers) {
  auto record = kText;
  record.replace(3, 7, "  -0.00");
  record.replace(10, 7, "-  5.67");
  const auto pose = parse_fastrak_text(record, default_fastrak_layout(), FastrakUnit::inch);
  ASSERT_TRUE(pose);
  EXPECT_EQ(pose->position_in_source_m.x, 0);
  EXPECT_DOUBLE_EQ(pose->position_in_source_m.y, -5.67 * 0.0254);
}

TEST(FastrakRecord, WhatDoesNotFitItsFieldIsCutOff) {
  const StationPose far{.station = 1, .position_in_source_m = {100, -100, 0}, .source_from_station = {1, 0, 0, 0}};
  EXPECT_EQ(encode_fastrak(far, {}), "01  999.99-999.99   0.00   0.00   0.00   0.00\r\n");
}

TEST(FastrakLayoutTest, LengthsAreTheManuals) {
  EXPECT_EQ(default_fastrak_layout().text_bytes(), 47U);
  EXPECT_EQ(quaternion_fastrak_layout().binary_bytes(), 32U);
  EXPECT_EQ(layout_of("2,0,4,1").text_bytes(), 48U);
  EXPECT_EQ(layout_of("2,16,1").binary_bytes(), 3U + 12 + 1 + 2);
}

TEST(FastrakLayoutTest, WhatMakesNoSenseIsRefused) {
  for (const char* items : {"", "4,1", "2,,1", "2,8", "2,a", "2,49", "-2", "2,67", "2 ,1", "2,61,61,61,61,61,1",
                            "2,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0"}) {
    const auto layout = FastrakLayout::parse(items);
    ASSERT_FALSE(layout) << items;
    EXPECT_THAT(layout.error().message, ::testing::HasSubstr("FASTRAK items"));
  }
}

TEST(FastrakStatusTest, TheManualsSixteenConfigurations) {
  // Page 74, from 3FF (continuous, compensated, cm, binary) down to 3F0.
  for (unsigned code = 0; code < 16; ++code) {
    const std::string line = "21S3F"s + "0123456789ABCDEF"[code] + "    F31  2.00.13" + std::string(32, 'x').substr(1) + "\r\n";
    ASSERT_EQ(line.size(), 55U);
    const auto status = parse_fastrak_status(line);
    ASSERT_TRUE(status);
    EXPECT_EQ(status->is_binary, (code & 1) != 0);
    EXPECT_EQ(status->unit, (code & 2) != 0 ? FastrakUnit::centimetre : FastrakUnit::inch);
    EXPECT_EQ(status->is_compensating, (code & 4) != 0);
    EXPECT_EQ(status->is_continuous, (code & 8) != 0);
    EXPECT_EQ(status->error, 0);
    EXPECT_EQ(status->receivers, 1U);
    EXPECT_EQ(encode_fastrak_status(*status), line);
  }
}

TEST(FastrakStatusTest, OtherLinesAreNone) {
  const std::string good = encode_fastrak_status({.station = 2, .error = 107, .receivers = 5, .version = "2.0.13"});
  const auto status = parse_fastrak_status(good);
  ASSERT_TRUE(status);
  EXPECT_EQ(status->station, 2);
  EXPECT_EQ(status->error, 107);
  EXPECT_EQ(status->receivers, 5U);
  EXPECT_FALSE(parse_fastrak_status(good.substr(0, 54)));
  auto other = good;
  other[3] = 'G';
  EXPECT_FALSE(parse_fastrak_status(other));
  EXPECT_FALSE(parse_fastrak_status(encode_fastrak_error("Z", -99)));
}

// ---------------------------------------------------------------------------------------------------------------------

class TrackerUnderTest : public FedDecoder<FastrakDecoder> {
 public:
  explicit TrackerUnderTest(std::string_view items = "2,11,0", FastrakUnit unit = FastrakUnit::centimetre)
      : FedDecoder({.layout = layout_of(items),
                    .unit = unit,
                    .delay = from_seconds(kFastrakDelay_s),
                    .stream_of_station = [](int station) { return static_cast<StreamId>(100 + station); }}) {}

  const StationPose& pose(std::size_t index) const { return std::get<StationPose>(samples().at(index).payload); }
};

std::string digest_of(const TrackerUnderTest& tracker) {
  std::string digest;
  for (std::size_t i = 0; i < tracker.samples().size(); ++i) {
    digest += std::to_string(to_ns(tracker.samples()[i].header.arrival_time)) + " " + std::to_string(tracker.pose(i).station) +
              " " + std::to_string(tracker.pose(i).position_in_source_m.x) + "\n";
  }
  return digest + describe(tracker.counters());
}

struct Form {
  std::string name;
  std::string items;
  std::string record;
};
void PrintTo(const Form& form, std::ostream* out) { *out << form.name; }

class FastrakStream : public ::testing::TestWithParam<Form> {
 protected:
  TrackerUnderTest make() const { return TrackerUnderTest(GetParam().items); }
  std::string record(int station = 1) const {
    auto record = GetParam().record;
    record[1] = static_cast<char>('0' + station);
    return record;
  }
  std::string troubled_stream(std::size_t noise_bytes) const {
    std::mt19937 random(20261122);
    std::string noise;
    for (std::size_t i = 0; i < noise_bytes; ++i) noise += static_cast<char>(random() & 0xFFU);
    auto wrong = record();
    wrong[18] = '\x7f';
    auto short_one = record();
    short_one.erase(9, 1);
    std::string stream = record().substr(7);
    for (const auto& piece :
         {record(1), record(2), record(3), record(4), short_one, record(1), wrong, record(2), std::string(9, '\0'), record(3),
          encode_fastrak_status({.unit = FastrakUnit::centimetre}), record(4), encode_fastrak_error("Zz", -99), record(1),
          noise, record(2), record(3), record(2).substr(0, 20)}) {
      stream += piece;
    }
    return stream;
  }
};

INSTANTIATE_TEST_SUITE_P(Forms, FastrakStream,
                         ::testing::Values(Form{"Binary", "2,11,0", kBinary}, Form{"Text", "2,4,1", kText}),
                         [](const auto& instance) { return instance.param.name; });

TEST_P(FastrakStream, StationsTakeTurns) {
  auto tracker = make();
  for (int cycle = 0; cycle < 3; ++cycle) {
    for (int station = 1; station <= 4; ++station) tracker.feed(record(station));
  }
  ASSERT_EQ(tracker.samples().size(), 12U);
  EXPECT_EQ(tracker.samples()[6].header.stream, 103);
  EXPECT_EQ(tracker.pose(6).station, 3);
  EXPECT_EQ(tracker.samples()[6].header.sequence, 1U) << "each station counts its own";
  EXPECT_EQ(describe(tracker.counters()), "good 12 bad 0 skipped 0 text 0");
}

TEST_P(FastrakStream, SampleTimeIsTheFirstBytesLessTheDelayForEverySplit) {
  const std::string text = "\r\n\0zz"s + record();
  for (std::size_t split = 0; split <= text.size(); ++split) {
    auto tracker = make();
    tracker.feed(text.substr(0, split));
    tracker.feed(text.substr(split));
    ASSERT_EQ(tracker.samples().size(), 1U) << split;
    const auto& header = tracker.samples()[0].header;
    EXPECT_EQ(header.arrival_time, kFirstArrival + kByteTime * 5) << split;
    EXPECT_EQ(header.arrival_time - header.sample_time, Duration{3'750'000});
  }
}

TEST_P(FastrakStream, TroubleIsTheSameHoweverItIsCut) {
  const auto text = troubled_stream(4000);
  auto whole = make();
  whole.feed(text);
  for (std::size_t size = 1; size < 100; ++size) {
    auto cut = make();
    cut.feed_in_pieces(text, size);
    ASSERT_EQ(digest_of(cut), digest_of(whole)) << "pieces of " << size;
  }
}

TEST_P(FastrakStream, NoGoodRecordIsLostInTrouble) {
  auto tracker = make();
  tracker.feed(troubled_stream(0));
  EXPECT_EQ(tracker.samples().size(), 11U);
  EXPECT_EQ(tracker.counters().text_lines, 2U);
  // The short one, the wrong one and the zeros.
  EXPECT_EQ(tracker.counters().bad_records, 3U);
}

TEST_P(FastrakStream, ADroppedByteCostsOneRecord) {
  for (std::size_t lost = 0; lost < record().size(); ++lost) {
    auto damaged = record(2);
    damaged.erase(lost, 1);
    auto tracker = make();
    tracker.feed(record(1) + damaged + record(3) + record(4));
    ASSERT_GE(tracker.samples().size(), 3U) << lost;
    EXPECT_EQ(tracker.pose(tracker.samples().size() - 1).station, 4) << lost;
    EXPECT_EQ(tracker.pose(tracker.samples().size() - 2).station, 3) << lost;
    EXPECT_GE(tracker.counters().bad_records, 1U) << lost;
  }
}

TEST_P(FastrakStream, AnUnpluggedStationIsJustNotThere) {
  auto tracker = make();
  for (int cycle = 0; cycle < 5; ++cycle) tracker.feed(record(1) + record(2) + record(4));
  EXPECT_EQ(describe(tracker.counters()), "good 15 bad 0 skipped 0 text 0");
  for (const auto& sample : tracker.samples()) EXPECT_NE(sample.header.stream, 103);
}

TEST_P(FastrakStream, PowerOnNoiseIsSkippedAndNotBad) {
  std::string noise;
  for (const char c : {'\x00', '\xff', '\xf8', '\x80', '\xfe'}) noise.append(3000, c);
  auto tracker = make();
  tracker.feed(noise + record());
  EXPECT_EQ(tracker.samples().size(), 1U);
  EXPECT_EQ(tracker.counters().bad_records, 0U);
  EXPECT_EQ(tracker.counters().skipped_bytes, 15000U);
}

TEST_P(FastrakStream, MegabytesWithoutARecordAreSkipped) {
  std::mt19937 random(3);
  std::string noise;
  for (int i = 0; i < 64 * 1024; ++i) noise += static_cast<char>(random() & 0xFFU);
  for (const auto& text : {noise, std::string(1'000'000, '0'), std::string(500'000, '2'), std::string(500'000, ' '),
                           "01 "s + std::string(500'000, '1'), "2 E"s + std::string(500'000, 'E')}) {
    auto tracker = make();
    tracker.feed(text);
    EXPECT_TRUE(tracker.samples().empty());
    // A beginning may still be waited for; then the next records are found.
    tracker.feed("\xff\xff"s + record(1) + record(2) + record(3));
    EXPECT_GE(tracker.samples().size(), 3U);
  }
}

TEST_P(FastrakStream, ResetForgetsAHalfRecord) {
  auto tracker = make();
  tracker.feed(record().substr(0, 20));
  tracker.decoder().reset();
  tracker.feed(record(2));
  EXPECT_EQ(describe(tracker.counters()), "good 1 bad 0 skipped 0 text 0");
}

TEST(FastrakStreamForms, SwitchingBetweenTextAndBinaryIsReadOn) {
  const auto layout = quaternion_fastrak_layout();
  const auto pose = parse_fastrak_binary(kBinary, layout, FastrakUnit::centimetre);
  ASSERT_TRUE(pose);
  const std::string text = encode_fastrak(*pose, {layout, false, FastrakUnit::centimetre});
  ASSERT_EQ(text.size(), layout.text_bytes());
  TrackerUnderTest tracker;
  tracker.feed(kBinary + kBinary + text + text + kBinary);
  EXPECT_EQ(describe(tracker.counters()), "good 5 bad 0 skipped 0 text 0");
  EXPECT_NEAR(tracker.pose(2).position_in_source_m.z, 0.4, 1e-9);
}

TEST(FastrakStreamForms, ZerosAndOnesInsideFloatsDoNotBeginRecords) {
  // Every float is made of the bytes '0', '1', ' ' and the like: each looks like the header of a record.
  const StationPose pose{
      .station = 1, .position_in_source_m = {0.0, 0.0, 0.0}, .source_from_station = *normalised({0.70711, 0.70711, 0, 0})};
  std::string record = encode_fastrak(pose, {quaternion_fastrak_layout(), true, FastrakUnit::centimetre});
  record.replace(3, 12,
                 "01 \x41"
                 "01 \x41"
                 "01 \x41");
  TrackerUnderTest tracker;
  for (int i = 0; i < 20; ++i) tracker.feed(record);
  EXPECT_EQ(describe(tracker.counters()), "good 20 bad 0 skipped 0 text 0");
  // Entering in the middle: found again at the next record.
  TrackerUnderTest late;
  late.feed(record.substr(3) + record + record);
  EXPECT_EQ(late.samples().size(), 2U);
}

TEST(FastrakStreamForms, TheTrackersOwnWordOnItsUnitCounts) {
  TrackerUnderTest tracker("2,11,0", FastrakUnit::inch);
  tracker.feed(kBinary);
  tracker.feed(encode_fastrak_status({.is_binary = true, .unit = FastrakUnit::centimetre}) + kBinary);
  tracker.feed(encode_fastrak_status({.is_binary = true, .unit = FastrakUnit::inch}) + kBinary);
  ASSERT_EQ(tracker.samples().size(), 3U);
  EXPECT_DOUBLE_EQ(tracker.pose(0).position_in_source_m.z, 40 * 0.0254);
  EXPECT_DOUBLE_EQ(tracker.pose(1).position_in_source_m.z, 0.4);
  EXPECT_DOUBLE_EQ(tracker.pose(2).position_in_source_m.z, 40 * 0.0254);
}

TEST(FastrakStreamForms, AnErrorLetterMarksTheSample) {
  auto record = kBinary;
  record[2] = 'x';
  TrackerUnderTest tracker;
  tracker.feed(record);
  ASSERT_EQ(tracker.samples().size(), 1U);
  EXPECT_EQ(tracker.samples()[0].header.status, kStatusDeviceError);
  EXPECT_FALSE(tracker.pose(0).valid);
}

TEST(FastrakStreamForms, SkippedStationsAtASlowRateAreNoFault) {
  // At 38400 baud a record of text does not fit its share of the cycle: the tracker leaves some out, in order.
  TrackerUnderTest tracker("2,4,1", FastrakUnit::inch);
  for (const int station : {1, 3, 1, 3, 2, 4}) {
    auto record = kText;
    record[1] = static_cast<char>('0' + station);
    tracker.feed(record);
  }
  EXPECT_EQ(describe(tracker.counters()), "good 6 bad 0 skipped 0 text 0");
}

TEST(MagneticTracker, ADecoderIsMadeFromTheStreamsMetadataAlone) {
  StreamTable streams;
  const auto raw = raw_stream("tracker", MagneticTrackerOptions{.stations = {1, 3}}, "serial:/dev/ttyUSB1");
  EXPECT_EQ(raw.topic, "/tracker/raw");
  EXPECT_EQ(raw.metadata.at("rate_hz"), "60");
  EXPECT_EQ(raw.metadata.at("items"), "2,11,0");
  EXPECT_EQ(raw.metadata.at("unit"), "cm");
  const auto decoder = make_decoder(raw, streams);
  ASSERT_NE(decoder, nullptr);
  struct Collector : SampleSink {
    bool receive(Sample sample) override {
      samples.push_back(std::move(sample));
      return true;
    }
    std::vector<Sample> samples;
  } collector;
  RawBytes bytes;
  bytes.size = static_cast<std::uint16_t>(kBinary4.size());
  std::ranges::transform(kBinary4, bytes.storage.begin(), [](char c) { return static_cast<std::byte>(c); });
  decoder->decode(Sample{.payload = bytes}, collector);
  ASSERT_EQ(collector.samples.size(), 1U);
  const auto stream = streams.find("/tracker/station4/pose");
  ASSERT_TRUE(stream);
  EXPECT_EQ(collector.samples[0].header.stream, *stream);
  EXPECT_EQ(collector.samples[0].header.sample_time, HostTime{} - Duration{3'750'000});
  const auto& info = streams.info(*stream);
  EXPECT_EQ(info.kind, "station_pose");
  EXPECT_EQ(info.role, StreamRole::derived);
  EXPECT_EQ(info.metadata.at("station"), "4");
  EXPECT_FALSE(info.metadata.contains("link"));
}

TEST(MagneticTracker, MetadataThatMakesNoSenseGivesNoDecoder) {
  StreamTable streams;
  auto raw = raw_stream("tracker", MagneticTrackerOptions{}, "x");
  raw.metadata["items"] = "nonsense";
  EXPECT_EQ(make_decoder(raw, streams), nullptr);
  raw = raw_stream("tracker", MagneticTrackerOptions{}, "x");
  raw.metadata["unit"] = "furlong";
  EXPECT_EQ(make_decoder(raw, streams), nullptr);
}

// A hand that a real FASTRAK followed at 100 Hz (CC0): every pose survives both forms as well as their digits allow.
TEST(FastrakRecorded, RealMotionSurvivesEncodingAndDecoding) {
  ROSEAU_REQUIRE_DATA(path, "data/em_polhemus_fastrak/user1_cup0.traj");
  std::ifstream file(path);
  int poses = 0;
  double m[4][4];
  const auto read_matrix = [&] {
    for (auto& row : m) {
      for (double& value : row) {
        if (!(file >> value)) return false;
      }
    }
    return true;
  };
  for (; read_matrix(); ++poses) {
    const auto rotation = quaternion_from_matrix(
        {Vec3{m[0][0], m[0][1], m[0][2]}, Vec3{m[1][0], m[1][1], m[1][2]}, Vec3{m[2][0], m[2][1], m[2][2]}});
    ASSERT_TRUE(rotation);
    const StationPose pose{.station = 1, .position_in_source_m = {m[0][3], m[1][3], m[2][3]}, .source_from_station = *rotation};
    for (const bool is_binary : {false, true}) {
      const FastrakLayout layout = is_binary ? quaternion_fastrak_layout() : default_fastrak_layout();
      const std::string record = encode_fastrak(pose, {layout, is_binary, FastrakUnit::centimetre});
      const auto back = is_binary ? parse_fastrak_binary(record, layout, FastrakUnit::centimetre)
                                  : parse_fastrak_text(record, layout, FastrakUnit::centimetre);
      ASSERT_TRUE(back);
      EXPECT_NEAR(back->position_in_source_m.x, m[0][3], is_binary ? 1e-6 : 5.1e-5);
      EXPECT_NEAR(back->position_in_source_m.z, m[2][3], is_binary ? 1e-6 : 5.1e-5);
      const Matrix3 matrix = matrix_from_quaternion(back->source_from_station);
      EXPECT_NEAR(matrix[0].y, m[0][1], 3e-4);
      EXPECT_NEAR(matrix[2].x, m[2][0], 3e-4);
      EXPECT_NEAR(matrix[1].z, m[1][2], 3e-4);
    }
  }
  EXPECT_GT(poses, 80);
}

}  // namespace
}  // namespace roseau::wire
