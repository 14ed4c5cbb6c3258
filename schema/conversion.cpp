#include "schema/conversion.h"

#include <algorithm>
#include <utility>

#include "core/image_coding/image_decoder.h"
#include "schema/image_motion.h"
#include "schema/messages.h"
#include "schema/wire.h"

namespace roseau::schema {

namespace {

constexpr std::string_view kPlumbBob = "plumb_bob";

// ---------------------------------------------------------------------------------------------------------------------
// Payload -> message. What differs from its payload is converted first; the rest is written as it is.

RawImageMessage message_of(const Frame& frame, const SampleHeader& header, const StreamTable& streams) {
  return {.frame_id = streams.info(header.stream).device,
          .width = frame.width,
          .height = frame.height,
          .encoding = std::string(to_string(frame.format)),
          .step = frame.stride,
          .exposure_duration = frame.exposure_duration,
          .data = frame.bytes()};
}

CameraCalibrationMessage message_of(const CameraCalibration& camera, const SampleHeader& header, const StreamTable& streams) {
  const auto& rotation = camera.rotation_camera_from_world;
  return {.frame_id = streams.info(header.stream).device,
          .width = camera.width,
          .height = camera.height,
          .distortion_model = std::string(kPlumbBob),
          .d = {camera.distortion.begin(), camera.distortion.end()},
          .k = {camera.fx_px, 0, camera.cx_px, 0, camera.fy_px, camera.cy_px, 0, 0, 1},
          .r = {1, 0, 0, 0, 1, 0, 0, 0, 1},
          .p = {camera.fx_px, 0, camera.cx_px, 0, 0, camera.fy_px, camera.cy_px, 0, 0, 0, 1, 0},
          .rotation_camera_from_world = {rotation.begin(), rotation.end()},
          .position_in_world_m = camera.position_in_world_m};
}

SkipMessage message_of(const Skip& skip, const SampleHeader&, const StreamTable& streams) {
  return {streams.info(skip.stream).topic, skip.sequence};
}

ImageAnnotationsMessage message_of(const ImageMotion& motion, const SampleHeader& header, const StreamTable&) {
  return annotations_from_motion(motion, header.sample_time);
}

PoseInFrameMessage message_of(const StationPose& station, const SampleHeader& header, const StreamTable& streams) {
  return {.frame_id = streams.info(header.stream).device,
          .pose = {station.position_in_source_m, station.source_from_station},
          .station = station.station,
          .device_status = station.device_status,
          .valid = station.valid};
}

PosesInFrameMessage message_of(const MarkerPositions& positions, const SampleHeader&, const StreamTable&) {
  PosesInFrameMessage message{.frame_id = positions.frame};
  for (const auto& marker : positions.markers) {
    message.poses.push_back({.position = marker.position_m});
    message.markers.push_back({.name = marker.name,
                               .has_covariance = marker.covariance_m2.has_value(),
                               .covariance_m2 = marker.covariance_m2.value_or(Covariance3{})});
  }
  return message;
}

template <class Payload>
const Payload& message_of(const Payload& payload, const SampleHeader&, const StreamTable&) {
  return payload;
}

// ---------------------------------------------------------------------------------------------------------------------
// Message -> payload

template <class Message>
Result<void> read_message(std::span<const std::byte> bytes, SampleHeader& header, Message& message) {
  Clear clear;
  SampleHeader unused;
  describe_message(clear, unused, message);
  Reader reader(bytes);
  reader.read([&](Reader& io) { describe_message(io, header, message); });
  if (reader.fault()) return *reader.fault();
  return {};
}

Result<CameraCalibration> payload_of(const CameraCalibrationMessage& message) {
  CameraCalibration camera;
  camera.width = message.width;
  camera.height = message.height;
  if ((message.distortion_model != kPlumbBob && !message.distortion_model.empty()) ||
      message.d.size() > camera.distortion.size()) {
    return Error{ErrorCode::unsupported, "distortion model '" + message.distortion_model + "' with " +
                                             std::to_string(message.d.size()) + " parameters is not plumb_bob"};
  }
  std::ranges::copy(message.d, camera.distortion.begin());
  if (message.k.size() == 9) {
    camera.fx_px = message.k[0];
    camera.cx_px = message.k[2];
    camera.fy_px = message.k[4];
    camera.cy_px = message.k[5];
  } else if (!message.k.empty()) {
    return Error{ErrorCode::corrupt, "K has " + std::to_string(message.k.size()) + " numbers instead of 9"};
  }
  if (message.rotation_camera_from_world.size() == camera.rotation_camera_from_world.size()) {
    std::ranges::copy(message.rotation_camera_from_world, camera.rotation_camera_from_world.begin());
  } else if (!message.rotation_camera_from_world.empty()) {
    return Error{ErrorCode::corrupt, "rotation_camera_from_world has not 9 numbers"};
  }
  camera.position_in_world_m = message.position_in_world_m;
  return camera;
}

Result<MarkerPositions> payload_of(const PosesInFrameMessage& message) {
  // Other programs write poses without names.
  if (!message.markers.empty() && message.markers.size() != message.poses.size()) {
    return Error{ErrorCode::corrupt,
                 std::to_string(message.markers.size()) + " markers with " + std::to_string(message.poses.size()) + " poses"};
  }
  MarkerPositions positions;
  positions.frame = message.frame_id;
  for (const Pose& pose : message.poses) positions.markers.push_back({.position_m = pose.position});
  for (std::size_t i = 0; i < message.markers.size(); ++i) {
    positions.markers[i].name = message.markers[i].name;
    if (message.markers[i].has_covariance) positions.markers[i].covariance_m2 = message.markers[i].covariance_m2;
  }
  return positions;
}

/// A coded frame's pixels; another frame's are copied.
Result<void> take_pixels(const FrameView& view, std::span<std::byte> pixels) {
  if (view.storage == ImageStorage::raw) {
    std::ranges::copy(view.pixels, pixels.begin());
    return {};
  }
  thread_local image::ImageDecoder decoder;  // keeps its memory from frame to frame
  const auto decoded = decoder.decode(view.coded, pixels, view.format);
  return decoded ? Result<void>{} : decoded.error();
}

Result<Frame> copy_frame(const FrameView& view, FramePool* frames) {
  if (frames == nullptr) return Error{ErrorCode::invalid_argument, "frames were not asked for (no frame pool)"};
  if (view.pixel_bytes() > frames->buffer_bytes()) {
    return Error{ErrorCode::unsupported, "an image of " + std::to_string(view.pixel_bytes()) + " bytes in a stream that has " +
                                             std::to_string(frames->buffer_bytes()) + " bytes per image"};
  }
  Frame frame{.width = view.width,
              .height = view.height,
              .stride = view.stride,
              .format = view.format,
              .exposure_duration = view.exposure_duration};
  frame.pixels = frames->acquire();
  if (!frame.pixels) return Error{ErrorCode::busy, "all frame buffers are in use"};
  if (auto taken = take_pixels(view, frame.pixels.writable_bytes()); !taken) return taken.error();
  return frame;
}

/// Reads any kind whose message is its payload.
template <class Payload>
Result<Payload> parse_payload(std::span<const std::byte> bytes, SampleHeader& header, const StreamTable&, FramePool*) {
  Payload payload;
  if (auto read = read_message(bytes, header, payload); !read) return read.error();
  return payload;
}

template <>
Result<Frame> parse_payload(std::span<const std::byte> bytes, SampleHeader& header, const StreamTable&, FramePool* frames) {
  auto view = parse_frame(bytes, header);
  if (!view) return view.error();
  header = view->header;
  return copy_frame(*view, frames);
}

template <>
Result<CameraCalibration> parse_payload(std::span<const std::byte> bytes, SampleHeader& header, const StreamTable&,
                                        FramePool*) {
  CameraCalibrationMessage message;
  if (auto read = read_message(bytes, header, message); !read) return read.error();
  return payload_of(message);
}

template <>
Result<Skip> parse_payload(std::span<const std::byte> bytes, SampleHeader& header, const StreamTable& streams, FramePool*) {
  SkipMessage message;
  if (auto read = read_message(bytes, header, message); !read) return read.error();
  const auto stream = streams.find(message.topic);
  if (!stream) return Error{ErrorCode::not_found, "skips a sample of " + message.topic + ", which the session does not have"};
  return Skip{*stream, message.sequence};
}

template <>
Result<ImageMotion> parse_payload(std::span<const std::byte> bytes, SampleHeader& header, const StreamTable&, FramePool*) {
  ImageAnnotationsMessage message;
  if (auto read = read_message(bytes, header, message); !read) return read.error();
  return motion_from_annotations(message);
}

template <>
Result<StationPose> parse_payload(std::span<const std::byte> bytes, SampleHeader& header, const StreamTable&, FramePool*) {
  PoseInFrameMessage message;
  if (auto read = read_message(bytes, header, message); !read) return read.error();
  return StationPose{.station = message.station,
                     .position_in_source_m = message.pose.position,
                     .source_from_station = message.pose.orientation,
                     .device_status = message.device_status,
                     .valid = message.valid};
}

template <>
Result<MarkerPositions> parse_payload(std::span<const std::byte> bytes, SampleHeader& header, const StreamTable&, FramePool*) {
  PosesInFrameMessage message;
  if (auto read = read_message(bytes, header, message); !read) return read.error();
  return payload_of(message);
}

using ParseSample = Result<Sample> (*)(std::span<const std::byte>, SampleHeader, const StreamTable&, FramePool*);

template <std::size_t Index>
Result<Sample> parse_sample(std::span<const std::byte> bytes, SampleHeader header, const StreamTable& streams,
                            FramePool* frames) {
  auto payload = parse_payload<std::variant_alternative_t<Index, Payload>>(bytes, header, streams, frames);
  if (!payload) return std::move(payload).error();
  return Sample{header, std::move(*payload)};
}

template <std::size_t... Indices>
constexpr auto make_parsers(std::index_sequence<Indices...>) {
  return std::array<ParseSample, sizeof...(Indices)>{parse_sample<Indices>...};
}
constexpr auto kParsers = make_parsers(std::make_index_sequence<kSampleKindCount>());

}  // namespace

std::span<const std::byte> serialize_head(const Sample& sample, const StreamTable& streams, std::vector<std::byte>& head) {
  head.clear();
  Writer writer(head);
  std::visit(
      [&](const auto& payload) {
        const auto& message = message_of(payload, sample.header, streams);
        describe_message(writer, sample.header, message);
      },
      sample.payload);
  return writer.tail();
}

std::span<const std::byte> serialize_coded_head(const Sample& sample, const StreamTable& streams,
                                                std::vector<std::byte>& head) {
  const auto& frame = std::get<Frame>(sample.payload);
  ROSEAU_CHECK(frame.coded && frame.coded.format != ImageStorage::raw);
  head.clear();
  Writer writer(head);
  const CompressedImageMessage image{.frame_id = streams.info(sample.header.stream).device,
                                     .format = std::string(to_string(frame.coded.format)),
                                     .exposure_duration = frame.exposure_duration,
                                     .encoding = std::string(to_string(frame.format)),
                                     .data = frame.coded.bytes()};
  describe_message(writer, sample.header, image);
  return writer.tail();
}

void serialize(const Sample& sample, const StreamTable& streams, std::vector<std::byte>& message) {
  const auto tail = serialize_head(sample, streams, message);
  message.insert(message.end(), tail.begin(), tail.end());
}

void serialize_compressed_image(const SampleHeader& header, std::string_view frame_id, std::string_view format,
                                std::span<const std::byte> coded, std::vector<std::byte>& message) {
  message.clear();
  Writer writer(message);
  const CompressedImageMessage image{.frame_id = std::string(frame_id), .format = std::string(format), .data = coded};
  describe_message(writer, header, image);
  message.insert(message.end(), coded.begin(), coded.end());
}

Result<Sample> parse(SampleKind kind, std::span<const std::byte> message, const SampleHeader& known, const StreamTable& streams,
                     FramePool* frames) {
  auto sample = kParsers.at(static_cast<std::size_t>(kind))(message, known, streams, frames);
  if (!sample) return sample.error().with_context(std::string(schema_name(kind)));
  return sample;
}

namespace {

Result<FrameView> view_of(const SampleHeader& header, const RawImageMessage& image) {
  const auto format = pixel_format_from_string(image.encoding);
  if (!format) return format.error();
  const std::size_t size = std::size_t{image.step} * image.height;
  if (image.step < image.width * bytes_per_pixel(*format) || size > image.data.size()) {
    return Error{ErrorCode::corrupt, std::to_string(image.data.size()) + " bytes for an image of " +
                                         std::to_string(image.width) + "x" + std::to_string(image.height) + " with " +
                                         std::to_string(image.step) + " bytes per row"};
  }
  return FrameView{.header = header,
                   .width = image.width,
                   .height = image.height,
                   .stride = image.step,
                   .format = *format,
                   .exposure_duration = image.exposure_duration,
                   .pixels = image.data.first(size)};
}

Result<FrameView> view_of(const SampleHeader& header, const CompressedImageMessage& image, Duration exposure_duration) {
  const auto info = image::read_info(image.data);
  if (!info) return info.error().code == ErrorCode::unsupported ? info.error().with_context(image.format) : info.error();
  FrameView view{.header = header,
                 .width = info->width,
                 .height = info->height,
                 .stride = static_cast<std::uint32_t>(info->row_bytes()),
                 .format = info->format,
                 .exposure_duration = exposure_duration,
                 .storage = info->coding,
                 .coded = image.data};
  if (image.encoding.empty()) return view;  // another program's
  const auto format = pixel_format_from_string(image.encoding);
  if (!format) return format.error();
  if (bytes_per_pixel(*format) != bytes_per_pixel(info->format)) {
    return Error{ErrorCode::corrupt,
                 "a " + std::string(to_string(info->format)) + " picture where " + image.encoding + " is said"};
  }
  view.format = *format;
  return view;
}

}  // namespace

Result<FrameView> parse_frame(std::span<const std::byte> message, const SampleHeader& known) {
  SampleHeader header = known;
  RawImageMessage raw;
  CompressedImageMessage coded;
  // What both have has the same number; where numbers mean different things, their types differ, but for the names in field 4.
  Reader reader(message);
  reader.read([&](Reader& io) {
    describe_message(io, header, raw);
    describe_message(io, header, coded);
  });
  if (reader.fault()) return *reader.fault();
  const bool is_coded = !coded.format.empty() || !coded.data.empty();
  return is_coded ? view_of(header, coded, raw.exposure_duration) : view_of(header, raw);
}

}  // namespace roseau::schema
