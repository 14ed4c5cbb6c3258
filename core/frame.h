// Frames: pixels in a fixed pool of buffers, passed around by lease. The last lease to go returns the buffer to its pool.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string_view>
#include <utility>

#include "core/result.h"
#include "core/time.h"

namespace roseau {

enum class PixelFormat : std::uint8_t { mono8, mono16, bgr8, rgb8 };

/// Foxglove's RawImage encoding name ("mono8", ...).
std::string_view to_string(PixelFormat format);
Result<PixelFormat> pixel_format_from_string(std::string_view name);
std::size_t bytes_per_pixel(PixelFormat format);

class FramePool;

namespace detail {
struct FrameBuffer;
void add_reference(FrameBuffer* buffer);
void drop_reference(FrameBuffer* buffer);
}  // namespace detail

/// Shared read access to one frame buffer. Copying shares, destruction releases; both are lock-free and allocate nothing.
/// Thread-safe in the way of shared_ptr: different leases may be used by different threads.
class FrameLease {
 public:
  FrameLease() = default;
  FrameLease(const FrameLease& other) : buffer_(other.buffer_) {
    if (buffer_ != nullptr) detail::add_reference(buffer_);
  }
  FrameLease(FrameLease&& other) noexcept : buffer_(std::exchange(other.buffer_, nullptr)) {}
  FrameLease& operator=(FrameLease other) noexcept {
    std::swap(buffer_, other.buffer_);
    return *this;
  }
  ~FrameLease() {
    if (buffer_ != nullptr) detail::drop_reference(buffer_);
  }

  explicit operator bool() const { return buffer_ != nullptr; }
  std::span<const std::byte> bytes() const;

  /// Shares memory that is no pool's: a ring's, a driver's own buffer. `owner` keeps it alive and is let go, by whichever
  /// thread, when the last lease is gone. Costs an allocation, which a pool's lease does not.
  static FrameLease of(std::span<std::byte> bytes, std::shared_ptr<void> owner);

  /// The driver's write access. Only before the lease is shared: CHECKs that this is the only one.
  std::span<std::byte> writable_bytes();

 private:
  friend class FramePool;
  explicit FrameLease(detail::FrameBuffer* buffer) : buffer_(buffer) {}
  detail::FrameBuffer* buffer_ = nullptr;
};

/// At most 64 buffers of one size, allocated and touched in the constructor so that capture never faults a page in.
/// acquire() and release are lock-free. The memory outlives the pool object while leases exist.
class FramePool {
 public:
  FramePool(std::size_t buffer_count, std::size_t buffer_bytes);
  ~FramePool();
  FramePool(const FramePool&) = delete;
  FramePool& operator=(const FramePool&) = delete;

  /// An empty lease when every buffer is out: the caller counts a drop.
  FrameLease acquire();
  std::size_t buffer_bytes() const;
  std::size_t free_count() const;

 private:
  std::shared_ptr<struct FramePoolState> state_;
};

/// How a camera's pictures are kept: as they came, losslessly compressed, or lossy.
enum class ImageStorage : std::uint8_t { raw, png, jpeg };
std::string_view to_string(ImageStorage storage);
Result<ImageStorage> image_storage_from_string(std::string_view name);

/// A whole PNG or JPEG file in memory: the stored form of a frame. Empty lease: none.
struct CodedImage {
  FrameLease lease;
  std::size_t size = 0;  // bytes of the lease in use
  ImageStorage format = ImageStorage::png;

  explicit operator bool() const { return static_cast<bool>(lease); }
  std::span<const std::byte> bytes() const { return lease.bytes().first(size); }
};

/// One image. Rows are `stride` bytes apart, top row first.
///
/// A frame may carry its stored form: from a camera that is stored lossy, whose pixels are what that decodes to, and from a
/// recording of coded pictures. Who stores the frame takes `coded` as it is; everybody else looks at the pixels. A frame that is
/// kept only to be stored may have let go of its pixels: bytes() is empty then.
struct Frame {
  FrameLease pixels;
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  std::uint32_t stride = 0;
  PixelFormat format = PixelFormat::mono8;
  Duration exposure_duration{0};  // 0 = unknown
  CodedImage coded;

  std::span<const std::byte> bytes() const {
    return pixels ? pixels.bytes().first(std::size_t{stride} * height) : std::span<const std::byte>{};
  }
};

}  // namespace roseau
