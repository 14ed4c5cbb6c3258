#include "drivers/camera/jpeg/frame_coder.h"

#include <algorithm>
#include <utility>

namespace roseau::camera {

namespace {

// Tracking holds some 20 frames when it is behind (skip_after_frames), the recorder a second of coded ones.
constexpr std::size_t kPixelBuffers = 32;
constexpr std::size_t kCodedBuffers = 64;

void grow(std::unique_ptr<FramePool>& pool, std::size_t count, std::size_t bytes) {
  if (pool == nullptr || pool->buffer_bytes() < bytes) pool = std::make_unique<FramePool>(count, bytes);
}

}  // namespace

CodedBuffers::Pair CodedBuffers::acquire(std::size_t pixel_bytes, std::size_t coded_bytes) {
  const std::scoped_lock lock(mutex_);
  grow(pixels_, kPixelBuffers, pixel_bytes);
  grow(coded_, kCodedBuffers, coded_bytes);
  return {pixels_->acquire(), coded_->acquire()};
}

CodedBuffers::Pair FrameCoder::buffers_for(const Frame& frame, CodedBuffers& buffers) {
  return buffers.acquire(image::view_of(frame).row_bytes() * frame.height,
                         image::PngEncoder::buffer_bytes(frame.width, frame.height, frame.format));
}

Result<void> FrameCoder::code(Frame& frame, CodedBuffers::Pair buffers) {
  const auto view = image::view_of(frame);
  if (auto valid = image::check(view); !valid) return valid;
  if (frame.format != PixelFormat::mono16) {
    scratch_.resize(image::JpegEncoder::buffer_bytes(view.width, view.height, view.format));
    const auto size = jpeg_.encode(view, scratch_);
    if (!size) return size.error();
    const std::span<const std::byte> file = std::span(scratch_).first(*size);
    if (*size < view.row_bytes() * view.height) {
      if (auto decoded = decoder_.decode(file, buffers.pixels.writable_bytes(), view.format); !decoded) return decoded.error();
      std::ranges::copy(file, buffers.coded.writable_bytes().begin());
      frame.pixels = std::move(buffers.pixels);
      frame.stride = static_cast<std::uint32_t>(view.row_bytes());
      frame.coded = {.lease = std::move(buffers.coded), .size = *size, .format = ImageStorage::jpeg};
      return {};
    }
  }
  const auto size = png_.encode(view, buffers.coded.writable_bytes());
  if (!size) return size.error();
  frame.coded = {.lease = std::move(buffers.coded), .size = *size, .format = ImageStorage::png};
  return {};
}

}  // namespace roseau::camera
