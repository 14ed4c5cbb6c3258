// Samples <-> recorded messages: the one conversion of each sample type. Used by the recorder and replay, by the live
// display, by the session tools and for the digest. Pure functions, safe to call from any thread.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/frame.h"
#include "core/result.h"
#include "core/sample.h"
#include "core/stream.h"
#include "schema/schemas.h"

namespace roseau::schema {

/// Writes the message of `sample` into `head` (replaced; its capacity is reused) except for a frame's pixels, which are
/// returned and not copied: the message is `head` followed by the returned bytes, which live as long as the frame's lease.
/// For every other kind the returned span is empty and `head` is the whole message. `streams` gives names to stream ids.
std::span<const std::byte> serialize_head(const Sample& sample, const StreamTable& streams, std::vector<std::byte>& head);

/// The whole message in one buffer (replaced; its capacity is reused). The same sample gives the same bytes.
void serialize(const Sample& sample, const StreamTable& streams, std::vector<std::byte>& message);

/// As serialize_head, of a frame in its stored form (Frame::coded, which must be there): a foxglove.CompressedImage. The
/// frame's pixels are not looked at.
std::span<const std::byte> serialize_coded_head(const Sample& sample, const StreamTable& streams, std::vector<std::byte>& head);

/// foxglove.CompressedImage of any picture that the caller has coded. `format`: "jpeg" or "png"; `frame_id`: device name.
void serialize_compressed_image(const SampleHeader& header, std::string_view frame_id, std::string_view format,
                                std::span<const std::byte> coded, std::vector<std::byte>& message);

/// The sample in `message`, a message of schema_name(kind).
///
/// `known` is what the caller knows already: the stream in any case, and times and sequence from the record around the
/// message. What the message itself says goes before it; messages of other programs carry no roseau header.
/// `streams` must hold the session's streams (a Skip names its stream by topic).
/// `frames` is needed for frames only: the pixels are copied, or those of a coded picture decoded, into one of its buffers.
/// Which of the two messages of a frame this is, foxglove.RawImage or foxglove.CompressedImage, is seen from its fields.
///
/// Errors: corrupt or truncated (no such message), unsupported (written by a newer program, or an image of another pixel
/// format or coding), busy (every buffer of `frames` is out: try again later), not_found (a Skip of an unknown topic).
Result<Sample> parse(SampleKind kind, std::span<const std::byte> message, const SampleHeader& known, const StreamTable& streams,
                     FramePool* frames = nullptr);

/// A frame message without copying or decoding its pixels, for tools and for callers that wait for a free buffer themselves.
struct FrameView {
  SampleHeader header;
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  std::uint32_t stride = 0;
  PixelFormat format = PixelFormat::mono8;
  Duration exposure_duration{0};
  std::span<const std::byte> pixels;  // exactly stride * height bytes, inside the message; empty for a coded picture
  ImageStorage storage = ImageStorage::raw;
  std::span<const std::byte> coded;  // inside the message: a PNG or JPEG file that decodes to rows of `stride` bytes

  std::size_t pixel_bytes() const { return std::size_t{stride} * height; }
};
/// Of a coded picture, only the first bytes are looked at.
Result<FrameView> parse_frame(std::span<const std::byte> message, const SampleHeader& known);

}  // namespace roseau::schema
