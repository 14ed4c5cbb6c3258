#include "recorder/control/past.h"

#include <algorithm>
#include <utility>

namespace roseau::recorder {

namespace {

// Where there are pictures, everything else gets this share of the bytes: a hundred streams at 100 Hz for a minute in 1 GiB.
constexpr std::uint64_t kShareWithoutPixels = 16;

/// What of a frame is stored: its coded form where it has one.
std::span<const std::byte> picture_of(const Frame& frame) { return frame.coded ? frame.coded.bytes() : frame.bytes(); }

std::uint64_t pixel_bytes_of(const Sample& sample) {
  const auto* frame = std::get_if<Frame>(&sample.payload);
  return frame == nullptr ? 0 : picture_of(*frame).size();
}

}  // namespace

std::uint64_t bytes_without_pixels(const Sample& sample) {
  std::uint64_t bytes = sizeof(KeptSample);
  if (const auto* motion = std::get_if<ImageMotion>(&sample.payload))
    bytes += motion->points.size() * sizeof(ImageMotion::Point);
  if (const auto* spectrum = std::get_if<ForceSpectrum>(&sample.payload)) {
    bytes += 5 * sizeof(float) * spectrum->frequency_hz.size();
  }
  return bytes;
}

Past::Past(PastOptions options)
    : options_(options),
      small_limit_(options.has_pictures ? options.bytes / kShareWithoutPixels : options.bytes),
      pixels_(options.length > Duration{0} ? options.bytes - small_limit_ : 0) {}

std::optional<KeptSample> Past::copy(const Sample& sample, HostTime log_time) {
  KeptSample kept{sample, log_time, bytes_without_pixels(sample)};
  if (auto* frame = std::get_if<Frame>(&kept.sample.payload)) {
    FrameLease copied = pixels_.copy(picture_of(*frame));
    if (!copied) return std::nullopt;
    if (frame->coded) {
      frame->coded.lease = std::move(copied);
      frame->pixels = {};  // nobody looks at them any more: they went through the analysis when they came
    } else {
      frame->pixels = std::move(copied);
    }
  }
  return kept;
}

void Past::keep(const Sample& sample, HostTime log_time) {
  if (options_.length == Duration{0}) return;
  newest_ = std::max(newest_, log_time);
  while (!samples_.empty() && samples_.front().log_time < newest_ - options_.length) drop_oldest();
  const std::uint64_t bytes = bytes_without_pixels(sample);
  std::optional<KeptSample> kept;
  while (true) {
    if (small_bytes_ + bytes <= small_limit_) kept = copy(sample, log_time);
    if (kept || samples_.empty()) break;
    drop_oldest();
    ++cut_off_;
  }
  if (!kept) {  // larger than all there is
    ++cut_off_;
    return;
  }
  small_bytes_ += bytes;
  pixel_bytes_ += pixel_bytes_of(sample);
  samples_.push_back(std::move(*kept));
}

void Past::drop_oldest() { static_cast<void>(take_oldest()); }

std::optional<KeptSample> Past::take_oldest() {
  if (samples_.empty()) return std::nullopt;
  KeptSample oldest = std::move(samples_.front());
  samples_.pop_front();
  small_bytes_ -= oldest.bytes;
  pixel_bytes_ -= pixel_bytes_of(oldest.sample);
  return oldest;
}

Duration Past::span() const {
  return samples_.empty() ? Duration{0} : std::max(Duration{0}, newest_ - samples_.front().log_time);
}

}  // namespace roseau::recorder
