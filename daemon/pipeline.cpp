#include "daemon/pipeline.h"

#include <algorithm>

#include "daemon/cpu_time.h"

namespace roseau::daemon {

namespace {
constexpr std::size_t kOperatorRing = 64;
// Cameras of a stereo pair expose within this of each other: a skipped frame takes its partner with it.
constexpr Duration kPairTolerance = std::chrono::milliseconds(8);

void add_up(std::vector<std::pair<std::string, double>>& sums, const std::vector<std::pair<std::string, double>>& parts) {
  for (const auto& [part, seconds] : parts) {
    const auto sum = std::ranges::find(sums, part, &std::pair<std::string, double>::first);
    if (sum == sums.end()) {
      sums.emplace_back(part, seconds);
    } else {
      sum->second += seconds;
    }
  }
}

}  // namespace

Pipeline::Pipeline(Options options, StreamTable& streams, sync::Sequencer::DecoderFactory make_decoder,
                   StageFactory make_stages, Hooks hooks)
    : options_(std::move(options)),
      streams_(streams),
      hooks_(std::move(hooks)),
      intake_(counters_),
      supervisor_(options_.supervisor, streams, intake_),
      make_decoder_(std::move(make_decoder)),
      make_stages_(std::move(make_stages)),
      analysis_(make_analysis()),
      sequencer_(make_sequencer()),
      operator_stream_(streams.add({.topic = "/roseau/operator", .kind = "operator_action"})),
      skip_stream_(streams.add({.topic = "/roseau/skips", .kind = "skip"})) {
  operator_inlet_ = &intake_.add_inlet(true, kOperatorRing);
}

std::unique_ptr<Analysis> Pipeline::make_analysis() {
  Stages stages = make_stages_();
  return std::make_unique<Analysis>(
      streams_, std::move(stages.trackers), std::move(stages.estimation), [this](const Sample& sample, HostTime log_time) {
        const bool bulky = sample.kind() == SampleKind::frame || sample.kind() == SampleKind::raw_bytes;
        if (!bulky && hooks_.analysed) hooks_.analysed(sample, log_time);
      });
}

std::unique_ptr<sync::Sequencer> Pipeline::make_sequencer() {
  return std::make_unique<sync::Sequencer>(
      options_.sequencer, streams_, counters_, make_decoder_,
      [this](const Sample& sample, HostTime log_time) {
        position_ns_.store(to_ns(log_time), std::memory_order_relaxed);
        if (hooks_.input) hooks_.input(sample, log_time);
      },
      [this](Sample&& sample, HostTime log_time) { on_ordered(std::move(sample), log_time); });
}

Pipeline::~Pipeline() {
  intake_.close();
  supervisor_.stop();
}

void Pipeline::add_source(std::unique_ptr<SampleSource> source) { supervisor_.add(std::move(source), options_.ring_capacity); }

void Pipeline::act(OperatorAction action, HostTime now) {
  const std::scoped_lock lock(operator_mutex_);  // an inlet has one producer: pages and signals share it
  Sample sample;
  sample.header = {.stream = operator_stream_, .sequence = actions_++, .arrival_time = now, .sample_time = now};
  sample.payload = std::move(action);
  operator_inlet_->receive(std::move(sample));
}

void Pipeline::take(Sample sample) {
  sequencer_->take(std::move(sample));
  take_new_skips();
}

void Pipeline::take_new_skips() {
  for (auto& skip : std::exchange(new_skips_, {})) sequencer_->take(std::move(skip));
}

/// Everything taken so far goes to the analysis.
void Pipeline::flush() {
  sequencer_->flush();
  take_new_skips();
  sequencer_->flush();
}

void Pipeline::restart(bool discard) {
  if (discard) {
    analysis_->abandon();
  } else {
    flush();
    analysis_->finish();
  }
  if (hooks_.restarted) hooks_.restarted(/*whole=*/!discard);
  new_skips_.clear();
  last_skipped_.reset();
  auto fresh = make_analysis();
  sequencer_ = make_sequencer();
  const std::scoped_lock lock(analysis_mutex_);
  add_up(earlier_cpu_s_, analysis_->cpu_seconds());
  analysis_ = std::move(fresh);
}

bool Pipeline::is_skipped(const Sample& frame) {
  const StreamInfo& stream = streams_.info(frame.header.stream);
  if (options_.recorded_skips.contains({stream.topic, frame.header.sequence})) return true;
  if (options_.skip_after_frames == 0) return false;
  const bool partner_skipped = last_skipped_ && frame.header.sample_time - *last_skipped_ < kPairTolerance;
  if (!partner_skipped && analysis_->frames_waiting(stream.device) < options_.skip_after_frames) return false;
  last_skipped_ = frame.header.sample_time;
  Sample skip;
  skip.header = frame.header;
  skip.header.stream = skip_stream_;
  skip.header.sequence = skips_++;
  // Decided now: as an input of this moment it is never late itself.
  skip.header.arrival_time = position();
  skip.header.sample_time = position();
  skip.payload = Skip{.stream = frame.header.stream, .sequence = frame.header.sequence};
  new_skips_.push_back(std::move(skip));
  counters_.of(frame.header.stream).dropped.fetch_add(1, std::memory_order_relaxed);
  return true;
}

void Pipeline::on_ordered(Sample&& sample, HostTime log_time) {
  if (sample.kind() == SampleKind::frame) {
    if (hooks_.frame) hooks_.frame(sample, log_time);
    if (is_skipped(sample)) return;
  }
  analysis_->submit(std::move(sample), log_time);
}

void Pipeline::run(const std::stop_token& stop) {
  const double begin_cpu_s = cpu_seconds_of(CLOCK_THREAD_CPUTIME_ID);
  supervisor_.start();
  bool operator_open = true;
  intake_.run(stop, {.take = [this](Sample sample) { take(std::move(sample)); },
                     .idle =
                         [this, &operator_open] {
                           // The operator's inlet has no end of its own: it ends with the last source.
                           if (operator_open && supervisor_.all_finished()) {
                             operator_open = false;
                             operator_inlet_->finish();
                           }
                         },
                     .flush = [this] { flush(); },
                     .restart = [this](bool discard) { restart(discard); }});
  intake_.close();
  supervisor_.stop();
  flush();
  analysis_->finish();
  sequencer_cpu_s_ = cpu_seconds_of(CLOCK_THREAD_CPUTIME_ID) - begin_cpu_s;
}

std::vector<std::pair<std::string, double>> Pipeline::cpu_seconds() const {
  const std::scoped_lock lock(analysis_mutex_);
  auto used = earlier_cpu_s_;
  add_up(used, analysis_->cpu_seconds());
  used.emplace_back("sequencer", sequencer_cpu_s_.load());
  used.emplace_back("process", cpu_seconds_of(CLOCK_PROCESS_CPUTIME_ID));
  return used;
}

}  // namespace roseau::daemon
