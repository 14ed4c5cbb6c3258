#include "recorder/image_coder.h"

#include <algorithm>
#include <utility>

#include "core/image_coding/png_encoder.h"

namespace roseau::recorder {

namespace {

// Coded frames that wait for their turn or in an unfinished chunk (which holds at most half as many, session_writer.cpp).
constexpr std::size_t kBuffers = 32;
constexpr std::chrono::milliseconds kBufferWait{1};
constexpr std::size_t kMostThreads = 4;

Result<CodedImage> code(image::PngEncoder& encoder, const Frame& frame, FrameLease buffer) {
  const auto size = encoder.encode(image::view_of(frame), buffer.writable_bytes());
  if (!size) return size.error();
  return CodedImage{.lease = std::move(buffer), .size = *size, .format = ImageStorage::png};
}

}  // namespace

std::size_t default_coding_threads() {
  return std::clamp<std::size_t>(std::thread::hardware_concurrency() / 2, 1, kMostThreads);
}

ImageCoder::ImageCoder(std::size_t threads) : thread_count_(threads) {}

ImageCoder::~ImageCoder() {
  {
    const std::scoped_lock lock(mutex_);
    stopping_ = true;
  }
  work_ready_.notify_all();
}

void ImageCoder::submit(QueuedSample queued, bool to_png) {
  const std::scoped_lock lock(mutex_);
  jobs_.push_back({.done = {.queued = std::move(queued), .error = {}}, .ready = !to_png});
  const std::size_t number = jobs_end_++;
  if (!to_png) return;
  to_code_.push_back(number);
  if (threads_.empty()) {
    for (std::size_t i = 0; i < thread_count_; ++i) threads_.emplace_back([this] { code_until_stopped(); });
  }
  work_ready_.notify_one();
}

std::optional<ImageCoder::Done> ImageCoder::take(std::chrono::steady_clock::time_point deadline) {
  std::unique_lock lock(mutex_);
  if (jobs_.empty()) return std::nullopt;
  if (!done_ready_.wait_until(lock, deadline, [this] { return jobs_.front().ready; })) return std::nullopt;
  Done done = std::move(jobs_.front().done);
  jobs_.pop_front();
  ++jobs_begin_;
  return done;
}

/// Buffers are given out in the order of the jobs, and those before a job need none that it has: so the oldest, which the
/// writer waits for, gets one in the end.
FrameLease ImageCoder::buffer_for(const Frame& frame) {
  const std::size_t bytes = image::PngEncoder::buffer_bytes(frame.width, frame.height, frame.format);
  if (buffers_ == nullptr || buffers_->buffer_bytes() < bytes) buffers_ = std::make_unique<FramePool>(kBuffers, bytes);
  return buffers_->acquire();
}

void ImageCoder::code_until_stopped() {
  image::PngEncoder encoder;
  std::unique_lock lock(mutex_);
  while (!stopping_) {
    work_ready_.wait(lock, [this] { return stopping_ || !to_code_.empty(); });
    if (stopping_) return;
    // A job stays where it is in memory while others are added behind it and taken before it.
    const std::size_t number = to_code_.front();
    Job& job = jobs_[number - jobs_begin_];
    Frame& frame = std::get<Frame>(job.done.queued.sample.payload);
    FrameLease buffer = buffer_for(frame);
    if (!buffer) {
      lock.unlock();
      std::this_thread::sleep_for(kBufferWait);
      lock.lock();
      continue;
    }
    to_code_.pop_front();
    lock.unlock();
    auto coded = code(encoder, frame, std::move(buffer));
    if (coded) {
      frame.coded = std::move(*coded);
      frame.pixels = {};
    } else {
      job.done.error = coded.error();
    }
    lock.lock();
    job.ready = true;
    done_ready_.notify_one();
  }
}

}  // namespace roseau::recorder
