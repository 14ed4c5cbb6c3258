#include "core/frame.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <deque>

namespace roseau {

namespace {
constexpr std::size_t kMaxBuffers = 64;       // one bit each in FramePoolState::free_mask
constexpr std::size_t kBufferAlignment = 64;  // cache line; wide enough for every vector load

struct AlignedDelete {
  void operator()(std::byte* bytes) const { ::operator delete[](bytes, std::align_val_t{kBufferAlignment}); }
};
}  // namespace

namespace detail {
struct FrameBuffer {
  std::unique_ptr<std::byte[], AlignedDelete> bytes;  // a pool's
  std::span<std::byte> lent;                          // another owner's
  std::size_t size = 0;
  std::size_t index = 0;
  std::atomic<std::uint32_t> references{0};
  // While leased, the buffer keeps its pool's memory alive; set by acquire, moved out by the last release.
  std::shared_ptr<FramePoolState> keeps_alive;
  std::shared_ptr<void> owner;  // of lent memory

  std::byte* data() const { return owner ? lent.data() : bytes.get(); }
};
}  // namespace detail

struct FramePoolState {
  std::deque<detail::FrameBuffer> buffers;  // deque: FrameBuffer cannot move
  std::atomic<std::uint64_t> free_mask{0};
};

namespace detail {

void add_reference(FrameBuffer* buffer) { buffer->references.fetch_add(1, std::memory_order_relaxed); }

void drop_reference(FrameBuffer* buffer) {
  if (buffer->references.fetch_sub(1, std::memory_order_acq_rel) != 1) return;
  if (buffer->owner) {
    delete buffer;  // made by FrameLease::of
    return;
  }
  const std::shared_ptr<FramePoolState> pool = std::move(buffer->keeps_alive);
  pool->free_mask.fetch_or(std::uint64_t{1} << buffer->index, std::memory_order_release);
}

}  // namespace detail

std::span<const std::byte> FrameLease::bytes() const {
  if (buffer_ == nullptr) return {};
  return {buffer_->data(), buffer_->size};
}

std::span<std::byte> FrameLease::writable_bytes() {
  ROSEAU_CHECK(buffer_ != nullptr && buffer_->references.load(std::memory_order_relaxed) == 1);
  return {buffer_->data(), buffer_->size};
}

FrameLease FrameLease::of(std::span<std::byte> bytes, std::shared_ptr<void> owner) {
  ROSEAU_CHECK(owner != nullptr);
  auto buffer = std::make_unique<detail::FrameBuffer>();
  buffer->lent = bytes;
  buffer->size = bytes.size();
  buffer->references = 1;
  buffer->owner = std::move(owner);
  return FrameLease(buffer.release());
}

FramePool::FramePool(std::size_t buffer_count, std::size_t buffer_bytes) : state_(std::make_shared<FramePoolState>()) {
  ROSEAU_CHECK(buffer_count >= 1 && buffer_count <= kMaxBuffers);
  for (std::size_t index = 0; index < buffer_count; ++index) {
    auto& buffer = state_->buffers.emplace_back();
    buffer.bytes.reset(static_cast<std::byte*>(::operator new[](buffer_bytes, std::align_val_t{kBufferAlignment})));
    std::memset(buffer.bytes.get(), 0, buffer_bytes);
    buffer.size = buffer_bytes;
    buffer.index = index;
  }
  state_->free_mask = buffer_count == kMaxBuffers ? ~std::uint64_t{0} : (std::uint64_t{1} << buffer_count) - 1;
}

FramePool::~FramePool() = default;

FrameLease FramePool::acquire() {
  std::uint64_t mask = state_->free_mask.load(std::memory_order_acquire);
  while (mask != 0) {
    const auto index = static_cast<std::size_t>(std::countr_zero(mask));
    if (!state_->free_mask.compare_exchange_weak(mask, mask & (mask - 1), std::memory_order_acquire)) continue;
    auto& buffer = state_->buffers[index];
    buffer.references.store(1, std::memory_order_relaxed);
    buffer.keeps_alive = state_;
    return FrameLease(&buffer);
  }
  return {};
}

std::size_t FramePool::buffer_bytes() const { return state_->buffers.front().size; }

std::size_t FramePool::free_count() const {
  return static_cast<std::size_t>(std::popcount(state_->free_mask.load(std::memory_order_relaxed)));
}

namespace {
struct FormatName {
  PixelFormat format;
  std::string_view name;
  std::size_t bytes;
};
constexpr FormatName kFormats[] = {{PixelFormat::mono8, "mono8", 1},
                                   {PixelFormat::mono16, "mono16", 2},
                                   {PixelFormat::bgr8, "bgr8", 3},
                                   {PixelFormat::rgb8, "rgb8", 3}};

const FormatName& format_name(PixelFormat format) {
  const auto* found = std::ranges::find(kFormats, format, &FormatName::format);
  ROSEAU_CHECK(found != std::end(kFormats));
  return *found;
}
}  // namespace

std::string_view to_string(PixelFormat format) { return format_name(format).name; }

std::size_t bytes_per_pixel(PixelFormat format) { return format_name(format).bytes; }

Result<PixelFormat> pixel_format_from_string(std::string_view name) {
  const auto* found = std::ranges::find(kFormats, name, &FormatName::name);
  if (found == std::end(kFormats)) {
    return Error{ErrorCode::unsupported, "pixel format '" + std::string(name) + "' is not one of mono8, mono16, bgr8, rgb8"};
  }
  return found->format;
}

namespace {
constexpr std::string_view kStorageNames[] = {"raw", "png", "jpeg"};  // in the order of ImageStorage
}  // namespace

std::string_view to_string(ImageStorage storage) { return kStorageNames[static_cast<std::size_t>(storage)]; }

Result<ImageStorage> image_storage_from_string(std::string_view name) {
  const auto* found = std::ranges::find(kStorageNames, name);
  if (found == std::end(kStorageNames)) {
    return Error{ErrorCode::invalid_argument, "image storage '" + std::string(name) + "' is not one of raw, png, jpeg"};
  }
  return static_cast<ImageStorage>(found - std::begin(kStorageNames));
}

}  // namespace roseau
