#include "synthesis/rig/simulated_sonic.h"

#include <algorithm>
#include <utility>

#include "core/check.h"
#include "drivers/wire/anemometer.h"
#include "drivers/wire/wind_master.h"

namespace roseau::synthesis {

namespace {
constexpr std::uint64_t kTimingStream = 2000;
constexpr std::uint64_t kNoiseStream = 2001;
constexpr std::uint64_t kSplitStream = 2002;
constexpr double kBitsPerByte = 10;  // 8N1
constexpr std::uint64_t kNoisesPerRecord = 4;
}  // namespace

SimulatedSonic::SimulatedSonic(std::shared_ptr<const World> world)
    : world_(std::move(world)),
      times_(sonic().rate_hz, sonic().timing, world_->scene.seed, kTimingStream),
      noise_(world_->scene.seed, kNoiseStream),
      splits_(world_->scene.seed, kSplitStream),
      byte_time_(from_seconds(kBitsPerByte / sonic().baud)) {
  send_next_record();
}

void SimulatedSonic::declare(StreamTable& streams) {
  const wire::AnemometerOptions options{.model = wire::AnemometerModel::gill_windmaster,
                                        .north_offset_deg = sonic().north_offset_deg,
                                        .rate_hz = sonic().rate_hz,
                                        .delay_s = sonic().timing.latency_s};
  stream_ = streams.add(wire::raw_stream(name_, options, "simulated"));
}

Due SimulatedSonic::next() const {
  const Piece& piece = on_line_.front();
  return {piece.arrival, piece.arrival + byte_time_ * piece.bytes.size};
}

WindSample SimulatedSonic::measure(std::uint64_t record) const {
  WindSample sample = world_->wind_in_sonic_axes(sonic().position_in_world_m, times_.sample_time_s(record));
  const std::uint64_t first = record * kNoisesPerRecord;
  sample.u_mps += sonic().noise_mps * noise_.normal(first);
  sample.v_mps += sonic().noise_mps * noise_.normal(first + 1);
  sample.w_mps += sonic().noise_mps * noise_.normal(first + 2);
  sample.sonic_temperature_celsius += sonic().temperature_noise_celsius * noise_.normal(first + 3);
  return sample;
}

void SimulatedSonic::send_next_record() {
  const std::vector<std::byte> bytes = wire::encode_wind_master(measure(record_), wire::WindMasterFormat{});
  const Duration ready = from_seconds(times_.sample_time_s(record_) + times_.delay_s(record_));
  const Duration begin = std::max(ready, line_free_);
  const std::span all(bytes);
  std::size_t cut = all.size();
  if (splits_.uniform(2 * record_) < sonic().split_probability) {
    cut = 1 + splits_.bits(2 * record_ + 1) % (all.size() - 1);
  }
  send_piece(all.first(cut), begin);
  if (cut < all.size()) send_piece(all.subspan(cut), begin + byte_time_ * static_cast<Duration::rep>(cut));
  line_free_ = begin + byte_time_ * static_cast<Duration::rep>(all.size());
  ++record_;
}

void SimulatedSonic::send_piece(std::span<const std::byte> bytes, Duration arrival) {
  ROSEAU_CHECK(bytes.size() <= RawBytes::kCapacity);
  Piece piece{.arrival = arrival};
  std::ranges::copy(bytes, piece.bytes.storage.begin());
  piece.bytes.size = static_cast<std::uint16_t>(bytes.size());
  piece.bytes.byte_time = byte_time_;
  on_line_.push_back(piece);
}

bool SimulatedSonic::produce(HostTime start, SampleSink& sink) {
  const Piece piece = on_line_.front();
  on_line_.pop_front();
  if (on_line_.empty()) send_next_record();
  const HostTime arrival = start + piece.arrival;
  sink.receive({{.stream = stream_,
                 .sequence = static_cast<std::uint32_t>(pieces_handed_on_++),
                 .arrival_time = arrival,
                 .sample_time = arrival},
                piece.bytes});
  return true;
}

}  // namespace roseau::synthesis
