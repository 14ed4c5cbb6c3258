#include "sync/sequencer.h"

#include <algorithm>
#include <charconv>
#include <tuple>
#include <utility>

namespace roseau::sync {

namespace {

constexpr Duration kClockReportInterval = std::chrono::seconds(1);
constexpr Duration kDelayMargin = std::chrono::milliseconds(20);
// A frame number falling back by more than this is a device that started again, not a frame that came late.
constexpr std::uint32_t kRestartStep = 64;

/// The constant delay a stream states about itself; zero when it states none.
Duration stated_delay(const StreamInfo& info) {
  const auto found = info.metadata.find("delay_s");
  if (found == info.metadata.end()) return {};
  double delay_s = 0;
  const auto& text = found->second;
  std::from_chars(text.data(), text.data() + text.size(), delay_s);
  return from_seconds(delay_s);
}

}  // namespace

struct Sequencer::StreamState {
  const StreamInfo* info = nullptr;
  StreamCounts* counts = nullptr;
  std::unique_ptr<Decoder> decoder;
  bool decoder_asked = false;
  std::optional<std::uint32_t> last_sequence;
};

/// A heap of samples waiting for the window to pass, earliest on top.
class Sequencer::Held {
 public:
  void push(Sample&& sample, HostTime log_time, const std::string& topic) {
    items_.push_back({std::move(sample), log_time, next_number_++, &topic});
    std::ranges::push_heap(items_, later);
  }
  bool empty() const { return items_.empty(); }
  HostTime earliest() const { return items_.front().sample.header.sample_time; }
  std::pair<Sample, HostTime> pop() {
    std::ranges::pop_heap(items_, later);
    auto item = std::move(items_.back());
    items_.pop_back();
    return {std::move(item.sample), item.log_time};
  }

 private:
  struct Item {
    Sample sample;
    HostTime log_time;
    std::uint64_t number = 0;  // order of taking: decides between equals, so that the output is one order only
    const std::string* topic = nullptr;
  };
  static bool later(const Item& a, const Item& b) {
    const auto& ha = a.sample.header;
    const auto& hb = b.sample.header;
    if (ha.sample_time != hb.sample_time) return ha.sample_time > hb.sample_time;
    // By topic, not by stream id: ids follow the order in which device threads came up.
    if (ha.stream != hb.stream) return *a.topic > *b.topic;
    return std::tie(ha.sequence, a.number) > std::tie(hb.sequence, b.number);
  }
  std::vector<Item> items_;
  std::uint64_t next_number_ = 0;
};

Sequencer::Sequencer(Options options, StreamTable& streams, CounterTable& counters, DecoderFactory make_decoder,
                     InputTap on_input, OrderedOutput on_ordered)
    : options_(options),
      streams_(streams),
      counters_(counters),
      make_decoder_(std::move(make_decoder)),
      on_input_(std::move(on_input)),
      on_ordered_(std::move(on_ordered)),
      held_(std::make_unique<Held>()),
      window_(options.window),
      gap_topic_(streams.add({.topic = "/roseau/gaps", .kind = "gap", .role = StreamRole::derived})) {}

Sequencer::~Sequencer() = default;

Duration Sequencer::window_for(const StreamInfo& stream, Duration window) {
  const Duration delay = stated_delay(stream);
  return delay > Duration{} ? std::max(window, delay + kDelayMargin) : window;
}

Sequencer::StreamState& Sequencer::state_of(StreamId stream) {
  if (stream_states_.size() <= stream) stream_states_.resize(std::size_t{stream} + 1);
  auto& state = stream_states_[stream];
  if (state == nullptr) {
    state = std::make_unique<StreamState>();
    state->info = &streams_.info(stream);
    state->counts = &counters_.of(stream);
    window_ = window_for(*state->info, window_);
  }
  return *state;
}

void Sequencer::take(Sample input) {
  StreamState& state = state_of(input.header.stream);
  log_time_ = std::max(input.header.arrival_time, log_time_ + Duration{1});
  state.counts->received.fetch_add(1, std::memory_order_relaxed);
  state.counts->last_arrival_ns.store(to_ns(input.header.arrival_time), std::memory_order_relaxed);
  on_input_(input, log_time_);

  if (auto* bytes = std::get_if<RawBytes>(&input.payload); bytes != nullptr) {
    if (!std::exchange(state.decoder_asked, true)) state.decoder = make_decoder_(*state.info, streams_);
    if (state.decoder != nullptr) {
      struct Collector : SampleSink {
        explicit Collector(Sequencer& owner) : sequencer(owner) {}
        bool receive(Sample sample) override {
          StreamState& decoded = sequencer.state_of(sample.header.stream);
          decoded.counts->last_arrival_ns.store(to_ns(sample.header.arrival_time), std::memory_order_relaxed);
          sequencer.map_clock(decoded, sample);
          sequencer.hold(std::move(sample));
          return true;
        }
        Sequencer& sequencer;
      } collector(*this);
      state.decoder->decode(input, collector);
      state.counts->bad.store(state.decoder->counters().bad_records, std::memory_order_relaxed);
    }
  } else if (check_numbering(state, input)) {
    if (input.kind() == SampleKind::frame) map_clock(state, input);
    hold(std::move(input));
  }
  release_until(log_time_ - window_);
}

/// False: the sample is the one before again, and goes no further. Only frames carry their device's own numbers.
bool Sequencer::check_numbering(StreamState& state, Sample& sample) {
  if (sample.kind() != SampleKind::frame) return true;
  const std::uint32_t sequence = sample.header.sequence;
  const auto last = std::exchange(state.last_sequence, sequence);
  if (!last) return true;
  const std::uint32_t step = sequence - *last;  // modulo 2^32, so that a wrapped counter is no gap
  if (step == 0) {
    sample.header.status |= kStatusDuplicate;
    state.counts->bad.fetch_add(1, std::memory_order_relaxed);
    return false;
  }
  const bool restarted = sequence<*last&& * last - sequence> kRestartStep;
  if (step == 1 || restarted || step > (1U << 31)) return true;
  state.counts->gaps.fetch_add(step - 1, std::memory_order_relaxed);
  Sample gap;
  gap.header = sample.header;
  gap.header.stream = gap_topic_;
  gap.header.sequence = gap_count_++;
  gap.header.status = kStatusOk;
  gap.payload = Gap{.topic = state.info->topic, .missing = step - 1, .expected_sequence = *last + 1};
  hold(std::move(gap));
  return true;
}

void Sequencer::map_clock(StreamState& state, Sample& sample) {
  const std::string& device = state.info->device;
  if (device.empty()) return;
  auto& clock = clocks_[device];
  if (clock.model == nullptr) {
    if (sample.header.device_time) {
      clock.model = std::make_unique<LowerHullClock>();
    } else {
      clock.model = std::make_unique<HostStampedClock>();
    }
    clock.topic =
        streams_.add({.topic = "/" + device + "/clock", .kind = "clock_state", .role = StreamRole::derived, .device = device});
    clock.last_reported = log_time_;
  }
  clock.model->observe(sample.header.device_time, sample.header.arrival_time);
  if (sample.header.device_time) sample.header.sample_time = clock.model->to_host(*sample.header.device_time);
  report_clock(clock, device);
}

void Sequencer::report_clock(ClockSlot& clock, const std::string& device) {
  if (log_time_ - clock.last_reported < kClockReportInterval) return;
  clock.last_reported = log_time_;
  Sample report;
  report.header.stream = clock.topic;
  report.header.sequence = clock.reports++;
  report.header.arrival_time = log_time_;
  report.header.sample_time = log_time_;
  ClockState clock_state = clock.model->state();
  clock_state.device = device;
  report.payload = std::move(clock_state);
  hold(std::move(report));
}

void Sequencer::hold(Sample&& sample) {
  if (sample.header.sample_time < released_until_) {
    sample.header.status |= kStatusLate;
    state_of(sample.header.stream).counts->late.fetch_add(1, std::memory_order_relaxed);
    on_ordered_(std::move(sample), log_time_);
    return;
  }
  const std::string& topic = state_of(sample.header.stream).info->topic;
  held_->push(std::move(sample), log_time_, topic);
}

void Sequencer::release_until(HostTime limit) {
  while (!held_->empty() && held_->earliest() <= limit) {
    auto [sample, log_time] = held_->pop();
    released_until_ = std::max(released_until_, sample.header.sample_time);
    on_ordered_(std::move(sample), log_time);
  }
}

void Sequencer::flush() { release_until(HostTime{Duration::max()}); }

std::vector<ClockState> Sequencer::clocks() const {
  std::vector<ClockState> states;
  for (const auto& [device, clock] : clocks_) {
    states.push_back(clock.model->state());
    states.back().device = device;
  }
  return states;
}

}  // namespace roseau::sync
