// libprotobuf, given nothing but the embedded descriptor sets, must read what we write and write what we read.
#include "schema/conversion.h"

#include <gmock/gmock.h>
#include <google/protobuf/descriptor.pb.h>
#include <google/protobuf/dynamic_message.h>
#include <google/protobuf/util/json_util.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "core/image_coding/jpeg.h"
#include "core/image_coding/png_encoder.h"
#include "schema/wire.h"
#include "tests/support/samples.h"

namespace roseau::schema {
namespace {

namespace pb = google::protobuf;

std::string_view as_text(std::span<const std::byte> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

std::vector<std::byte> as_bytes(std::string_view text) {
  const auto bytes = std::as_bytes(std::span(text));
  return {bytes.begin(), bytes.end()};
}

/// One message type as libprotobuf understands it from a session file alone.
class PeerSchema {
 public:
  explicit PeerSchema(const Schema& schema) {
    pb::FileDescriptorSet set;
    EXPECT_TRUE(set.ParseFromArray(schema.descriptor_set.data(), static_cast<int>(schema.descriptor_set.size())));
    for (const auto& file : set.file()) EXPECT_NE(pool_.BuildFile(file), nullptr) << file.name();
    descriptor_ = pool_.FindMessageTypeByName(std::string(schema.name));
    EXPECT_NE(descriptor_, nullptr) << schema.name;
  }
  std::unique_ptr<pb::Message> parse(std::span<const std::byte> bytes) {
    auto message = make();
    EXPECT_TRUE(message->ParseFromArray(bytes.data(), static_cast<int>(bytes.size())));
    return message;
  }
  std::unique_ptr<pb::Message> make() { return std::unique_ptr<pb::Message>(factory_.GetPrototype(descriptor_)->New()); }
  std::unique_ptr<pb::Message> from_json(const std::string& json) {
    auto message = make();
    EXPECT_TRUE(pb::util::JsonStringToMessage(json, message.get()).ok()) << json;
    return message;
  }

 private:
  pb::DescriptorPool pool_;
  pb::DynamicMessageFactory factory_;
  const pb::Descriptor* descriptor_ = nullptr;
};

/// Every field is set, in nested messages too, except those of Foxglove's that roseau does not use.
void expect_complete(const pb::Message& message) {
  static const std::set<std::string> unused = {
      "foxglove.ImageAnnotations.circles", "foxglove.ImageAnnotations.metadata", "foxglove.PointsAnnotation.outline_colors",
      "foxglove.PointsAnnotation.fill_color", "foxglove.TextAnnotation.background_color", "foxglove.TextAnnotation.metadata",
      "foxglove.Log.file", "foxglove.Log.line",
      // Only merged files have these (recorded_header_test).
      "roseau.SampleHeader.host_arrival_time", "roseau.SampleHeader.host_sample_time"};
  const auto* reflection = message.GetReflection();
  EXPECT_TRUE(reflection->GetUnknownFields(message).empty()) << message.GetTypeName() << " has fields its schema lacks";
  for (int i = 0; i < message.GetDescriptor()->field_count(); ++i) {
    const auto* field = message.GetDescriptor()->field(i);
    const auto& name = field->full_name();
    if (unused.contains(name) || name.starts_with("google.") || name.starts_with("foxglove.Color.") ||
        name.starts_with("foxglove.Point2.") || name.starts_with("foxglove.Quaternion.") ||
        name.starts_with("foxglove.PosesInFrame.Marker.") || name.starts_with("roseau.Covariance3.")) {
      continue;
    }
    if (field->is_repeated()) {
      EXPECT_GT(reflection->FieldSize(message, field), 0) << name;
      if (field->cpp_type() != pb::FieldDescriptor::CPPTYPE_MESSAGE) continue;
      for (int k = 0; k < reflection->FieldSize(message, field); ++k) {
        expect_complete(reflection->GetRepeatedMessage(message, field, k));
      }
    } else {
      EXPECT_TRUE(reflection->HasField(message, field)) << name;
      if (field->cpp_type() == pb::FieldDescriptor::CPPTYPE_MESSAGE) expect_complete(reflection->GetMessage(message, field));
    }
  }
}

std::string to_json(const pb::Message& message) {
  std::string json;
  pb::util::JsonPrintOptions options;
  options.preserve_proto_field_names = true;
  EXPECT_TRUE(pb::util::MessageToJsonString(message, &json, options).ok());
  return json;
}

constexpr std::string_view kTimestamp = R"("timestamp":"1970-01-02T10:17:36.700000001Z")";
constexpr std::string_view kHeader =
    R"("header":{"status":33,"sequence":4000000000,"arrival_time":"1970-01-02T10:17:36.789012345Z","device_time":"-1.500s"})";

/// What a stranger sees: the whole public contract of names, numbers and types, by kind.
std::string expected_json(SampleKind kind) {
  const auto own = [](std::string_view rest) {
    return "{" + std::string(kTimestamp) + "," + std::string(kHeader) + "," + std::string(rest) + "}";
  };
  switch (kind) {
    case SampleKind::raw_bytes:
      return own(R"("data":"AlEsMjI5LDAwMi43NCxNLDAwLAM=","line_errors":3,"byte_time":"0.000086806s")");
    case SampleKind::frame:
      return own(
          R"("width":5,"height":3,"encoding":"mono8","step":8,"data":"JsHI65oFHI/OCTDzws0EF3ZRmPvqleyf","frame_id":"camera0","exposure_duration":"0.004s")");
    case SampleKind::camera_calibration:
      return own(R"("width":1280,"height":1024,"distortion_model":"plumb_bob","D":[-0.1,0.02,0.001,-0.002,0.003],)"
                 R"("K":[1500.5,0,640.25,0,1501.5,512.75,0,0,1],"R":[1,0,0,0,1,0,0,0,1],)"
                 R"("P":[1500.5,0,640.25,0,0,1501.5,512.75,0,0,0,1,0],"frame_id":"camera0",)"
                 R"("rotation_camera_from_world":[0,1,0,0,0,1,1,0,0],"position_in_world_m":{"x":1,"y":-2,"z":3.5})");
    case SampleKind::operator_action:
      return own(R"("kind":"ADD_TARGET","text":"branch","camera":"camera0","region":{"x":10,"y":20,"width":30,"height":40})");
    case SampleKind::skip:
      return own(R"("topic":"/camera0/image","sequence":17)");
    case SampleKind::wind:
      return own(R"("u_mps":1.5,"v_mps":-2.5,"w_mps":0.25,"sonic_temperature_celsius":21.125,"speed_of_sound_mps":343.5,)"
                 R"("device_status":60,"valid":true)");
    case SampleKind::displacement:
      return own(R"("x":1.25,"y":-0.5,"covariance":{"xx":0.01,"xy":-0.002,"yy":0.03},"unit":"STRAIN",)"
                 R"("region":{"x":1,"y":2,"width":3,"height":4},"features":250,"health":0.75,"valid":true)");
    case SampleKind::image_motion: {
      const std::string stamp(kTimestamp);
      const std::string good = R"("outline_color":{"r":0.1,"g":0.85,"b":0.3,"a":1})";
      return own(
          R"("points":[{)" + stamp +
          R"(,"type":"LINE_LOOP","points":[{"x":90,"y":40},{"x":120,"y":40},{"x":120,"y":60},{"x":90,"y":60}],)" + good +
          R"(,"thickness":2,"metadata":[{"key":"name","value":"branch"},{"key":"health","value":"0.9"},{"key":"valid","value":"true"}]},{)" +
          stamp +
          R"(,"type":"LINE_LIST","points":[{"x":106,"y":50},{"x":110.5,"y":51.25}],"outline_color":{"r":0.95,"g":0.3,"b":0.1,"a":1},)"
          R"("thickness":1,"metadata":[{"key":"target","value":"0"},{"key":"good","value":"false"}]},{)" +
          stamp + R"(,"type":"LINE_LIST","points":[{"x":100,"y":50.5},{"x":100.5,"y":50.25}],)" + good +
          R"(,"thickness":1,"metadata":[{"key":"target","value":"0"},{"key":"good","value":"true"}]},{)" + stamp +
          R"(,"type":"LINE_LIST","points":[{"x":9.875,"y":20},{"x":10,"y":20}],"outline_color":{"r":0.6,"g":0.6,"b":0.6,"a":0.6},)"
          R"("thickness":1,"metadata":[{"key":"target","value":"background"},{"key":"good","value":"true"}]}],)"
          R"("texts":[{)" +
          stamp +
          R"(,"position":{"x":90,"y":40},"text":"branch","font_size":16,"text_color":{"r":0.1,"g":0.85,"b":0.3,"a":1}}])");
    }
    case SampleKind::identification:
      return own(
          R"("natural_frequency_hz":2.25,"natural_frequency_sd_hz":0.01,"damping_ratio":0.05,"damping_ratio_sd":0.004,)"
          R"("noise_sd":0.1,"force_slope":1.5,"peak_to_floor":40,"axis":{"x":0.8,"y":0.6},"window_s":60,"accepted":true)");
    case SampleKind::wind_estimate:
      return own(R"("wind_mps":3.5,"wind_sd_mps":0.25,"force_per_mass":12.5,"force_per_mass_sd":1.5,"lag_s":0.25,)"
                 R"("accepted":true,"settling":true,"scale_known":true)");
    case SampleKind::wind_calibration:
      return own(R"("reference":"/sonic/wind","gain":0.5,"offset":-0.25,"exponent":2,"delay_s":0.125,"direction_deg":270,)"
                 R"("explained":0.875,"correlation":0.9375,"rms_mps":0.375,"seconds_used":120)");
    case SampleKind::force_spectrum:
      return own(R"("frequency_hz":[0.5,1,1.5],"displacement_power":[1,2,3],"model_power":[4,5,6],"force_power":[7,8,9],)"
                 R"("force_noise_power":[10,11,12],"trust_low_hz":0.25,"trust_high_hz":8)");
    case SampleKind::clock_state:
      return own(R"("device":"camera0","offset_s":-12.5,"offset_sd_s":0.00025,"frequency_offset_ppm":35.5,"jitter_s":0.0005,)"
                 R"("samples":"9000000000","resets":2)");
    case SampleKind::gap:
      return own(R"("topic":"/camera0/image","missing":3,"expected_sequence":1001)");
    case SampleKind::drop:
      return own(R"("topic":"/camera0/image","stage":"recorder","count":"5000000000")");
    case SampleKind::health:
      return own(
          R"("streams":[{"topic":"/sonic/raw","received":"1","recorded":"2","dropped":"3","gaps":"4","bad":"5","late":"6",)"
          R"("rate_hz":20.5,"age_s":0.05}],"devices":[{"name":"sonic","state":"REOPENING",)"
          R"("message":"/dev/ttyUSB0 is gone: plug it in"}],"recorder":"DEGRADED","recorder_message":"the disk is full",)"
          R"("recording_path":"/data/a.mcap","recording_s":61.5,"recorded_bytes":"70000000000","disk_free_bytes":"80000000000",)"
          R"("recording_phase":"POST_TRIGGER","recording_cause":"trigger gust","recording_ends_s":12.5,"recording_part":3,)"
          R"("session_bytes":"90000000000","write_rate_bytes_per_s":2.5e8,"disk_free_s":320,"pre_trigger_s":9.5,)"
          R"("pre_trigger_bytes":"1000000000","pre_trigger_cut_off":"17","copy":{"directory":"/mnt/second","state":"RUNNING",)"
          R"("message":"slow","verified_bytes":"60000000000","behind_bytes":"10000000000"},"battery_percent":81.5,)"
          R"("on_battery":true)");
    case SampleKind::log:
      return own(R"("level":"ERROR","message":"no data","name":"sonic")");
    case SampleKind::station_pose:
      return own(R"("frame_id":"camera0","pose":{"position":{"x":0.25,"y":-0.5,"z":0.75},)"
                 R"("orientation":{"x":-0.5,"y":0.5,"z":-0.5,"w":0.5}},"station":3,"device_status":107,"valid":true)");
    case SampleKind::led_board_time:
      return own(R"("event":"RISING_EDGE","tick":4000000000,"microseconds":250,"sequence":7)");
    case SampleKind::marker_positions:
      return own(
          R"("frame_id":"world","poses":[{"position":{"x":1,"y":2,"z":3},"orientation":{"w":1}},)"
          R"({"position":{"x":4,"y":5,"z":6},"orientation":{"w":1}}],"markers":[{"name":"red","has_covariance":true,)"
          R"("covariance_m2":{"xx":1,"xy":0.5,"xz":0.25,"yy":2,"yz":0.125,"zz":3}},{"name":"blue","covariance_m2":{}}])");
    case SampleKind::modal_state:
      return own(R"("structure":"tree","natural_frequency_hz":[0.5,1.5],"damping_ratio":[0.05,0.0625],)"
                 R"("amplitude":[0.25,-0.125],"modal_force":[2,-1])");
  }
  return "";
}

class EveryKind : public ::testing::TestWithParam<std::size_t> {
 protected:
  EveryKind() : kind(static_cast<SampleKind>(GetParam())), sample(testing::filled_sample(kind, streams, pool)) {
    serialize(sample, streams, bytes);
  }
  StreamTable streams;
  FramePool pool{8, 24};
  SampleKind kind;
  Sample sample;
  std::vector<std::byte> bytes;
  /// What a reader of a session knows before it looks into the message.
  SampleHeader known() const { return {.stream = sample.header.stream}; }
};

INSTANTIATE_TEST_SUITE_P(Schema, EveryKind, ::testing::Range<std::size_t>(0, kSampleKindCount), [](const auto& parameter) {
  return std::string(to_string(static_cast<SampleKind>(parameter.param)));
});

TEST_P(EveryKind, IsWhatTheSchemaSays) {
  PeerSchema peer(schema_of(kind));
  const auto seen = peer.parse(bytes);
  expect_complete(*seen);
  // Compared as messages, so that only values count and not how a number is spelt.
  EXPECT_EQ(to_json(*seen), to_json(*peer.from_json(expected_json(kind))));
}

TEST_P(EveryKind, ComesBackBitForBit) {
  const auto back = parse(kind, bytes, known(), streams, &pool);
  ASSERT_TRUE(back) << back.error().message;
  EXPECT_EQ(back->header.stream, sample.header.stream);
  EXPECT_EQ(back->header.status, sample.header.status);
  EXPECT_EQ(back->header.sequence, sample.header.sequence);
  EXPECT_EQ(back->header.arrival_time, sample.header.arrival_time);
  EXPECT_EQ(back->header.sample_time, sample.header.sample_time);
  EXPECT_EQ(back->header.device_time, sample.header.device_time);
  EXPECT_EQ(back->kind(), kind);
  std::vector<std::byte> again;
  serialize(*back, streams, again);
  EXPECT_EQ(as_text(again), as_text(bytes));
}

TEST_P(EveryKind, ReadsWhatLibprotobufWrites) {
  PeerSchema peer(schema_of(kind));
  const std::string rewritten = peer.parse(bytes)->SerializeAsString();  // in order of field number
  const auto back = parse(kind, as_bytes(rewritten), known(), streams, &pool);
  ASSERT_TRUE(back) << back.error().message;
  std::vector<std::byte> again;
  serialize(*back, streams, again);
  EXPECT_EQ(as_text(again), as_text(bytes));
}

TEST_P(EveryKind, AbsentFieldsAreZeroNotTheStructsDefaults) {
  const auto back = parse(kind, {}, known(), streams, &pool);
  if (kind == SampleKind::skip) {
    ASSERT_FALSE(back);
    EXPECT_EQ(back.error().code, ErrorCode::not_found);
    return;
  }
  if (kind == SampleKind::frame) {
    ASSERT_FALSE(back);
    EXPECT_EQ(back.error().code, ErrorCode::unsupported);  // no pixel format
    return;
  }
  ASSERT_TRUE(back) << back.error().message;
  if (kind == SampleKind::wind) {
    EXPECT_EQ(std::get<WindSample>(back->payload).u_mps, 0);
    EXPECT_FALSE(std::get<WindSample>(back->payload).valid);
  }
}

TEST_P(EveryKind, CutAndBrokenMessagesAreErrorsOrSamplesButNeverCrash) {
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    const std::vector<std::byte> cut(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(size));  // own heap block
    static_cast<void>(parse(kind, cut, known(), streams, &pool).has_value());
  }
  std::mt19937 random(GetParam() + 1U);
  for (int round = 0; round < 2000; ++round) {
    auto broken = bytes;
    for (int i = 0; i < 3; ++i) broken[random() % broken.size()] = static_cast<std::byte>(random());
    static_cast<void>(parse(kind, broken, known(), streams, &pool).has_value());
  }
}

TEST_P(EveryKind, NamesGoBothWays) { EXPECT_EQ(kind_of_schema(schema_name(kind)), kind); }

// ---------------------------------------------------------------------------------------------------------------------

class Conversion : public ::testing::Test {
 protected:
  StreamTable streams;
  FramePool pool{2, 24};
  std::vector<std::byte> bytes;

  Sample round_trip(const Sample& sample) {
    serialize(sample, streams, bytes);
    auto back = parse(sample.kind(), bytes, {.stream = sample.header.stream}, streams, &pool);
    EXPECT_TRUE(back);
    return *back;
  }
};

TEST_F(Conversion, PosesOfOtherProgramsAreMarkersWithoutNames) {
  PeerSchema peer(schema_of(SampleKind::marker_positions));
  const auto parsed = [&](const std::string& json) {
    return parse(SampleKind::marker_positions, as_bytes(peer.from_json(json)->SerializeAsString()), {}, streams, &pool);
  };
  const auto nameless = parsed(R"({"frame_id":"map","poses":[{"position":{"x":1,"y":2,"z":3}}]})");
  ASSERT_TRUE(nameless) << nameless.error().message;
  const auto& positions = std::get<MarkerPositions>(nameless->payload);
  EXPECT_EQ(positions.frame, "map");
  ASSERT_EQ(positions.markers.size(), 1U);
  EXPECT_EQ(positions.markers[0].position_m.z, 3);
  EXPECT_FALSE(positions.markers[0].covariance_m2);
  const auto uneven = parsed(R"({"poses":[{"position":{"x":1}},{"position":{"x":2}}],"markers":[{"name":"red"}]})");
  ASSERT_FALSE(uneven);
  EXPECT_EQ(uneven.error().code, ErrorCode::corrupt);
}

TEST_F(Conversion, KeepsEveryBitOfUnusualNumbers) {
  const double quiet_nan_with_payload = std::bit_cast<double>(0x7FF8'0000'DEAD'BEEFULL);
  const Sample sample{testing::filled_header(SampleKind::wind, streams),
                      WindSample{kNotMeasured, quiet_nan_with_payload, -0.0, -std::numeric_limits<double>::infinity(),
                                 std::numeric_limits<double>::denorm_min(), 0xFFFF, false}};
  const auto back = std::get<WindSample>(round_trip(sample).payload);
  const auto bits = [](double value) { return std::bit_cast<std::uint64_t>(value); };
  EXPECT_EQ(bits(back.u_mps), bits(kNotMeasured));
  EXPECT_EQ(bits(back.v_mps), bits(quiet_nan_with_payload));
  EXPECT_EQ(bits(back.w_mps), bits(-0.0));
  EXPECT_EQ(back.sonic_temperature_celsius, -std::numeric_limits<double>::infinity());
  EXPECT_EQ(back.speed_of_sound_mps, std::numeric_limits<double>::denorm_min());
  EXPECT_EQ(back.device_status, 0xFFFF);
  EXPECT_FALSE(back.valid);
}

TEST_F(Conversion, KeepsEveryTime) {
  constexpr std::int64_t kMin = std::numeric_limits<std::int64_t>::min();
  constexpr std::int64_t kMax = std::numeric_limits<std::int64_t>::max();
  for (const std::int64_t time_ns :
       {kMin, kMin + 1, -1'000'000'001L, -1'000'000'000L, -1L, 0L, 1L, 999'999'999L, 1'000'000'000L, kMax}) {
    Sample sample{testing::filled_header(SampleKind::gap, streams), Gap{}};
    sample.header.sample_time = host_time_from_ns(time_ns);
    sample.header.arrival_time = host_time_from_ns(time_ns);
    sample.header.device_time = device_time_from_ns(time_ns);
    const Sample back = round_trip(sample);
    EXPECT_EQ(to_ns(back.header.sample_time), time_ns);
    EXPECT_EQ(to_ns(back.header.arrival_time), time_ns);
    ASSERT_TRUE(back.header.device_time);
    EXPECT_EQ(to_ns(*back.header.device_time), time_ns);
  }
}

TEST_F(Conversion, DeviceTimeZeroIsNotNoDeviceTime) {
  Sample sample{testing::filled_header(SampleKind::gap, streams), Gap{}};
  sample.header.device_time = DeviceTime{};
  EXPECT_TRUE(round_trip(sample).header.device_time.has_value());
  sample.header.device_time.reset();
  EXPECT_FALSE(round_trip(sample).header.device_time.has_value());
}

TEST_F(Conversion, PixelsAreNotCopiedWhenWriting) {
  const Sample sample = testing::filled_sample(SampleKind::frame, streams, pool);
  const auto pixels = std::get<Frame>(sample.payload).bytes();
  const auto tail = serialize_head(sample, streams, bytes);
  EXPECT_EQ(tail.data(), pixels.data());
  EXPECT_EQ(tail.size(), pixels.size());
  EXPECT_LT(bytes.size(), 120U);
}

TEST_F(Conversion, FrameNeedsAPoolAndAFreeBuffer) {
  const Sample sample = testing::filled_sample(SampleKind::frame, streams, pool);
  serialize(sample, streams, bytes);
  const auto error_with = [&](FramePool* frames) { return parse(SampleKind::frame, bytes, {}, streams, frames).error().code; };
  EXPECT_EQ(error_with(nullptr), ErrorCode::invalid_argument);
  const FrameLease second = pool.acquire();
  EXPECT_EQ(error_with(&pool), ErrorCode::busy);
  FramePool too_small(1, 23);
  EXPECT_EQ(error_with(&too_small), ErrorCode::unsupported);
}

TEST_F(Conversion, FrameSizesThatDoNotFitTheDataAreCorrupt) {
  PeerSchema peer(schema_of(SampleKind::frame));
  const auto error_of = [&](const std::string& json) {
    const std::string text = peer.from_json(json)->SerializeAsString();
    const auto parsed = parse_frame(as_bytes(text), {});
    return parsed ? std::string("ok") : parsed.error().message;
  };
  EXPECT_EQ(error_of(R"({"width":2,"height":2,"step":2,"encoding":"mono8","data":"AAAAAA=="})"), "ok");
  EXPECT_THAT(error_of(R"({"width":2,"height":3,"step":2,"encoding":"mono8","data":"AAAAAA=="})"),
              ::testing::HasSubstr("4 bytes"));
  EXPECT_THAT(error_of(R"({"width":3,"height":1,"step":2,"encoding":"mono8","data":"AAAAAA=="})"),
              ::testing::HasSubstr("per row"));
  // Products that would wrap around in 32 bits.
  EXPECT_THAT(error_of(R"({"width":1431655766,"height":1,"step":4,"encoding":"bgr8","data":"AAAAAA=="})"),
              ::testing::HasSubstr("per row"));
  EXPECT_THAT(error_of(R"({"width":2,"height":65536,"step":65536,"encoding":"mono8","data":"AAAAAA=="})"),
              ::testing::HasSubstr("4 bytes"));
  EXPECT_THAT(error_of(R"({"width":2,"height":2,"step":2,"encoding":"bayer_rggb8","data":"AAAAAA=="})"),
              ::testing::HasSubstr("bayer_rggb8"));
}

TEST_F(Conversion, MessagesOfOtherProgramsTakeWhatIsKnownOutsideThem) {
  PeerSchema peer(schema_of(SampleKind::frame));
  const std::string text =
      peer.from_json(
              R"({"timestamp":"1970-01-01T00:00:05Z","width":2,"height":2,"step":2,"encoding":"mono8","data":"AQIDBA=="})")
          ->SerializeAsString();
  const SampleHeader known{
      .stream = 3, .sequence = 42, .arrival_time = host_time_from_ns(6), .sample_time = host_time_from_ns(7)};
  const auto sample = parse(SampleKind::frame, as_bytes(text), known, streams, &pool);
  ASSERT_TRUE(sample);
  EXPECT_EQ(sample->header.stream, 3);
  EXPECT_EQ(sample->header.sequence, 42U);
  EXPECT_EQ(sample->header.arrival_time, host_time_from_ns(6));
  EXPECT_EQ(sample->header.sample_time, host_time_from_ns(5'000'000'000));
}

TEST_F(Conversion, NewerFilesUnknownFieldsAreSkippedAndUnknownChoicesSaidSo) {
  Sample sample{testing::filled_header(SampleKind::operator_action, streams),
                OperatorAction{OperatorAction::Kind::note, "gust"}};
  serialize(sample, streams, bytes);
  auto newer = bytes;
  for (const int byte : {0xFA, 0x3E, 0x02, 0x41, 0x42}) newer.push_back(static_cast<std::byte>(byte));  // field 1007, 2 bytes
  ASSERT_TRUE(parse(sample.kind(), newer, {}, streams));
  for (const int byte : {0x18, 0x63}) newer.push_back(static_cast<std::byte>(byte));  // kind = 99
  const auto unknown = parse(sample.kind(), newer, {}, streams);
  ASSERT_FALSE(unknown);
  EXPECT_EQ(unknown.error().code, ErrorCode::unsupported);
  EXPECT_THAT(unknown.error().message, ::testing::HasSubstr("choice 99"));
}

TEST_F(Conversion, TextThatIsNotUtf8IsRepairedSoThatOthersCanRead) {
  const Sample sample{testing::filled_header(SampleKind::log, streams),
                      LogEntry{LogEntry::Level::info, "sonic", "got \xFF\xC3("}};
  EXPECT_EQ(std::get<LogEntry>(round_trip(sample).payload).message, "got \xEF\xBF\xBD\xEF\xBF\xBD(");
  PeerSchema(schema_of(SampleKind::log)).parse(bytes);
}

TEST_F(Conversion, UnpackedNumbersAreReadToo) {
  // frequency_hz twice, one value each, as a writer without packing would: tag 29 = field 3, 32 bits.
  const std::string_view text("\x1D\x00\x00\x80\x3F\x1D\x00\x00\x00\x40", 10);
  const auto sample = parse(SampleKind::force_spectrum, as_bytes(text), {}, streams);
  ASSERT_TRUE(sample);
  EXPECT_THAT(std::get<ForceSpectrum>(sample->payload).frequency_hz, ::testing::ElementsAre(1.0F, 2.0F));
}

TEST_F(Conversion, LongNestedMessagesHaveLongLengths) {
  Health health;
  health.devices.push_back({"sonic", DeviceState::failed, std::string(20000, 'x')});
  const Sample sample{testing::filled_header(SampleKind::health, streams), health};
  EXPECT_EQ(std::get<Health>(round_trip(sample).payload).devices.at(0).message.size(), 20000U);
  expect_complete(*PeerSchema(schema_of(SampleKind::raw_bytes)).parse([&] {
    serialize(testing::filled_sample(SampleKind::raw_bytes, streams, pool), streams, bytes);
    return bytes;
  }()));
}

TEST_F(Conversion, CompressedImageIsFoxgloves) {
  const auto coded = as_bytes("not really a jpeg");
  serialize_compressed_image(testing::filled_header(SampleKind::frame, streams), "camera0", "jpeg", coded, bytes);
  PeerSchema peer(compressed_image_schema());
  const auto seen = peer.parse(bytes);
  EXPECT_EQ(to_json(*seen),
            to_json(*peer.from_json("{" + std::string(kTimestamp) + "," + std::string(kHeader) +
                                    R"(,"frame_id":"camera0","format":"jpeg","data":"bm90IHJlYWxseSBhIGpwZWc="})")));
}

/// A frame of one kind of pixels, with its stored form.
class CodedFrames : public Conversion {
 protected:
  Sample coded_sample(PixelFormat format, ImageStorage storage) {
    Sample sample{testing::filled_header(SampleKind::frame, streams), testing::filled_frame(frames, 6, 4, 24)};
    auto& frame = std::get<Frame>(sample.payload);
    frame.format = format;
    frame.coded = {.lease = stored.acquire(), .format = storage};
    const auto out = frame.coded.lease.writable_bytes();
    const auto view = image::view_of(frame);
    const auto size =
        storage == ImageStorage::png ? image::PngEncoder().encode(view, out) : image::JpegEncoder(90).encode(view, out);
    EXPECT_TRUE(size) << size.error().message;
    frame.coded.size = *size;
    return sample;
  }
  FramePool frames{4, 96};
  FramePool stored{4, 16'384};
};

TEST_F(CodedFrames, ComeBackWithEverythingThatTheFrameHad) {
  for (const PixelFormat format : {PixelFormat::mono8, PixelFormat::mono16, PixelFormat::bgr8, PixelFormat::rgb8}) {
    const Sample sample = coded_sample(format, ImageStorage::png);
    const auto& frame = std::get<Frame>(sample.payload);
    const auto tail = serialize_coded_head(sample, streams, bytes);
    EXPECT_EQ(tail.data(), frame.coded.bytes().data());  // not copied
    bytes.insert(bytes.end(), tail.begin(), tail.end());

    const auto back = parse(SampleKind::frame, bytes, {.stream = sample.header.stream}, streams, &frames);
    ASSERT_TRUE(back) << back.error().message;
    EXPECT_EQ(back->header.sequence, sample.header.sequence);
    EXPECT_EQ(back->header.sample_time, sample.header.sample_time);
    EXPECT_EQ(back->header.device_time, sample.header.device_time);
    EXPECT_EQ(back->header.status, sample.header.status);
    const auto& same = std::get<Frame>(back->payload);
    EXPECT_EQ(same.format, format);
    EXPECT_EQ(same.exposure_duration, frame.exposure_duration);
    ASSERT_EQ(same.width, 6U);
    ASSERT_EQ(same.height, 4U);
    const std::size_t row_bytes = 6 * bytes_per_pixel(format);
    for (std::size_t y = 0; y < 4; ++y) {
      EXPECT_THAT(same.bytes().subspan(y * same.stride, row_bytes),
                  ::testing::ElementsAreArray(frame.bytes().subspan(y * frame.stride, row_bytes)));
    }
    const auto view = parse_frame(bytes, {});
    ASSERT_TRUE(view);
    EXPECT_EQ(view->storage, ImageStorage::png);
    EXPECT_EQ(view->coded.size(), frame.coded.size);
    EXPECT_TRUE(view->pixels.empty());
    EXPECT_EQ(view->pixel_bytes(), 4 * row_bytes);
  }
}

TEST_F(CodedFrames, AreFoxglovesCompressedImages) {
  const Sample sample = coded_sample(PixelFormat::bgr8, ImageStorage::jpeg);
  const auto tail = serialize_coded_head(sample, streams, bytes);
  bytes.insert(bytes.end(), tail.begin(), tail.end());
  PeerSchema peer(compressed_image_schema());
  const auto seen = peer.parse(bytes);
  expect_complete(*seen);
  const std::string json = to_json(*seen);
  EXPECT_THAT(json, ::testing::HasSubstr(R"("format":"jpeg")"));
  EXPECT_THAT(json, ::testing::HasSubstr(R"("encoding":"bgr8")"));
  EXPECT_THAT(json, ::testing::HasSubstr(R"("exposure_duration":"0.004s")"));
  EXPECT_THAT(json, ::testing::HasSubstr(R"("frame_id":"camera0")"));
  EXPECT_EQ(kind_of_schema("foxglove.CompressedImage"), SampleKind::frame);
}

TEST_F(CodedFrames, OfOtherProgramsAreReadToo) {
  for (const ImageStorage storage : {ImageStorage::png, ImageStorage::jpeg}) {
    const Sample sample = coded_sample(PixelFormat::rgb8, storage);
    const SampleHeader known{.stream = sample.header.stream, .sequence = 42, .arrival_time = host_time_from_ns(6)};
    // Without roseau's fields, and the data before the rest.
    const auto coded = std::get<Frame>(sample.payload).coded.bytes();
    std::vector<std::byte> message;
    Writer writer(message);
    writer.bytes(2, coded);
    writer.text(4, "left");
    const auto back = parse(SampleKind::frame, message, known, streams, &frames);
    ASSERT_TRUE(back) << back.error().message;
    EXPECT_EQ(back->header.sequence, 42U);
    EXPECT_EQ(std::get<Frame>(back->payload).format, PixelFormat::rgb8);
    EXPECT_EQ(std::get<Frame>(back->payload).width, 6U);
  }
}

TEST_F(CodedFrames, ThatAreBrokenAreErrors) {
  const Sample sample = coded_sample(PixelFormat::mono8, ImageStorage::png);
  const auto tail = serialize_coded_head(sample, streams, bytes);
  std::vector<std::byte> message = bytes;
  message.insert(message.end(), tail.begin(), tail.end());
  message[message.size() - 20] ^= std::byte{1};
  EXPECT_EQ(parse(SampleKind::frame, message, {}, streams, &frames).error().code, ErrorCode::corrupt);
  message[message.size() - tail.size()] ^= std::byte{1};  // of the signature
  EXPECT_EQ(parse_frame(message, {}).error().code, ErrorCode::unsupported);

  // The pixels are not those that the message speaks of.
  Sample other = sample;
  std::get<Frame>(other.payload).format = PixelFormat::mono16;
  serialize_coded_head(other, streams, bytes);
  bytes.insert(bytes.end(), tail.begin(), tail.end());
  EXPECT_EQ(parse_frame(bytes, {}).error().code, ErrorCode::corrupt);
}

TEST(Schemas, UnknownMessageNameHasNoKind) { EXPECT_FALSE(kind_of_schema("roseau.Tomorrow")); }

}  // namespace
}  // namespace roseau::schema
