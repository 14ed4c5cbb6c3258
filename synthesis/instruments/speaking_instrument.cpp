#include "synthesis/instruments/speaking_instrument.h"

#include <algorithm>
#include <utility>

namespace roseau::synthesis {

namespace {
constexpr std::uint64_t kNoiseStream = 2300;
constexpr double kEndOfTime_s = 1e8;
// A host that stood still this long has missed what came meanwhile.
constexpr Duration kOverdue = std::chrono::seconds(1);
}  // namespace

SpeakingInstrument::SpeakingInstrument(std::shared_ptr<const SerialInstrument> instrument, std::unique_ptr<Console> console,
                                       std::uint64_t seed)
    : instrument_(std::move(instrument)),
      console_(std::move(console)),
      noise_(instrument_->line().byte_error_probability, seed, kNoiseStream),
      byte_time_(byte_time(instrument_->line())) {
  go_to(0);
}

Duration SpeakingInstrument::begin_of(std::uint64_t number) const {
  const SampleTimes& times = instrument_->times();
  return from_seconds(times.sample_time_s(number) + times.delay_s(number));
}

void SpeakingInstrument::go_to(std::uint64_t number) {
  number_ = number;
  if (instrument_->times().sample_time_s(number) > kEndOfTime_s) {
    next_ = Duration::max();
    return;
  }
  next_ = std::max(begin_of(number), line_free_) + byte_time_ * static_cast<Duration::rep>(last_size_);
}

std::string SpeakingInstrument::send(Duration now) {
  const SampleTimes& times = instrument_->times();
  if (now - next_ > kOverdue) {
    go_to(std::max(number_ + 1, times.first_from(to_seconds(now))));
    return {};
  }
  const std::uint64_t number = number_;
  const Duration begin = begin_of(number);
  const bool has_no_time = instrument_->line().discards_when_busy && begin < line_free_;
  std::string bytes;
  if (!times.is_dropped(number) && !has_no_time) bytes = console_->record(number, to_seconds(now));
  if (!bytes.empty()) {
    last_size_ = bytes.size();
    line_free_ = std::max(begin, line_free_) + byte_time_ * static_cast<Duration::rep>(bytes.size());
    noise_.apply(number, bytes);
  }
  go_to(number + 1);
  return bytes;
}

std::string SpeakingInstrument::answer(std::string_view received, Duration now) {
  return console_->take(received, to_seconds(now));
}

bool SpeakingInstrument::is_connected(Duration now) const { return !instrument_->times().is_pulled(to_seconds(now)); }

std::unique_ptr<EmulatedInstrument> make_speaking(std::shared_ptr<const Sonic> sonic, std::uint64_t seed) {
  auto console = std::make_unique<DeafConsole>(sonic);
  return std::make_unique<SpeakingInstrument>(std::move(sonic), std::move(console), seed);
}

std::unique_ptr<EmulatedInstrument> make_speaking(std::shared_ptr<const MagneticTracker> tracker, std::uint64_t seed) {
  auto console = std::make_unique<FastrakConsole>(tracker);
  return std::make_unique<SpeakingInstrument>(std::move(tracker), std::move(console), seed);
}

std::unique_ptr<EmulatedInstrument> make_speaking(std::shared_ptr<const LedBoard> board, std::uint64_t seed) {
  auto console = std::make_unique<LedBoardConsole>(board);
  return std::make_unique<SpeakingInstrument>(std::move(board), std::move(console), seed);
}

}  // namespace roseau::synthesis
