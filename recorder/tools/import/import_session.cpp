#include "recorder/tools/import/import_session.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <set>
#include <utility>

#include "core/decoder.h"
#include "drivers/wire/make_decoder.h"
#include "recorder/tools/import/import_feed.h"

namespace roseau::recorder {

namespace {

// Not 0: a time of 0 means "none" in session files.
constexpr HostTime kFirstSample{std::chrono::seconds{1}};

using Feeds = std::vector<std::unique_ptr<ImportFeed>>;

template <class Items>
Result<void> add_feeds(const Items& items, Feeds& feeds, const std::function<void()>& report) {
  for (const auto& item : items) {
    auto feed = make_feed(item);
    if (!feed) return feed.error();
    feeds.push_back(std::move(*feed));
    report();
  }
  return {};
}

Result<void> check_topics(const Feeds& feeds) {
  std::set<std::string> topics;
  for (const auto& feed : feeds) {
    for (const auto& stream : feed->describe()) {
      if (!topics.insert(stream.topic).second)
        return Error{ErrorCode::invalid_argument,
                     fmt::format("topic {} is given to two files: give one another name", stream.topic)};
    }
  }
  return {};
}

std::optional<Duration> earliest_begin(const Feeds& feeds) {
  std::optional<Duration> earliest;
  for (const auto& feed : feeds) {
    const auto begin = feed->begin();
    if (begin && (!earliest || *begin < *earliest)) earliest = begin;
  }
  return earliest;
}

}  // namespace

// What has been handed on of one stream.
struct Done {
  std::uint64_t samples = 0;
  std::uint64_t invalid = 0;
  double begin_s = 0;
  double end_s = 0;
  std::unique_ptr<Decoder> decoder;  // of its raw bytes, if anybody can read them
  std::size_t feed = 0;              // that it came from, directly or decoded
  bool is_decoded = false;
};

struct SessionImport::State {
  Feeds feeds;
  std::map<StreamId, Done> done;
  StreamTable* streams = nullptr;
  std::optional<Duration> utc_minus_host_time;

  // Index of the feed whose sample comes next; nothing at the end of all.
  Result<std::optional<std::size_t>> next_feed() {
    std::optional<std::size_t> next;
    HostTime next_time;
    for (std::size_t i = 0; i < feeds.size(); ++i) {
      const auto time = feeds[i]->next_time();
      if (!time) return time.error();
      if (!*time || (next && **time >= next_time)) continue;
      next = i;
      next_time = **time;
    }
    return next;
  }
};

SessionImport::SessionImport(std::unique_ptr<State> state) : state_(std::move(state)) {}
SessionImport::SessionImport(SessionImport&&) noexcept = default;
SessionImport& SessionImport::operator=(SessionImport&&) noexcept = default;
SessionImport::~SessionImport() = default;

std::optional<Duration> SessionImport::utc_minus_host_time() const { return state_->utc_minus_host_time; }

Result<SessionImport> SessionImport::prepare(const ImportPlan& plan, StreamTable& streams,
                                             const std::function<void(double)>& progress) {
  auto state = std::make_unique<State>();
  auto& feeds = state->feeds;
  const auto files = plan.videos.size() + plan.sonics.size() + plan.trackers.size() + plan.displacements.size();
  if (files == 0)
    return Error{ErrorCode::invalid_argument,
                 "nothing to import: name a video, a sonic file, a tracker file or a displacement series"};
  const auto report = [&] {
    if (progress) progress(static_cast<double>(feeds.size()) / static_cast<double>(files));
  };
  if (auto added = add_feeds(plan.videos, feeds, report); !added) return added.error();
  if (auto added = add_feeds(plan.sonics, feeds, report); !added) return added.error();
  if (auto added = add_feeds(plan.trackers, feeds, report); !added) return added.error();
  if (auto added = add_feeds(plan.displacements, feeds, report); !added) return added.error();
  if (auto checked = check_topics(feeds); !checked) return checked.error();

  const auto session_begin = plan.begin ? plan.begin : earliest_begin(feeds);
  std::vector<Duration> offsets;
  for (const auto& feed : feeds) {
    const auto begin = feed->begin();
    offsets.push_back(feed->start_offset() + (begin ? *begin - *session_begin : Duration{0}));
  }
  const HostTime begin_time = kFirstSample - std::ranges::min(offsets);
  if (session_begin) state->utc_minus_host_time = *session_begin - begin_time.time_since_epoch();
  for (std::size_t i = 0; i < feeds.size(); ++i) {
    if (auto started = feeds[i]->start(begin_time + offsets[i], streams); !started) return started.error();
  }
  state->streams = &streams;
  return SessionImport(std::move(state));
}

// Hands samples on and counts them.
class SessionImport::Counter : public SampleSink {
 public:
  Counter(State& state, SampleSink& sink) : state_(state), sink_(sink) {}

  // A sample that a feed gave, and behind it what decoding makes of it.
  bool take(std::size_t feed, Sample sample) {
    feed_ = feed;
    is_decoding_ = false;
    auto [found, is_new] = state_.done.try_emplace(sample.header.stream);
    auto& done = found->second;
    if (is_new && sample.kind() == SampleKind::raw_bytes)
      done.decoder = wire::make_decoder(state_.streams->info(sample.header.stream), *state_.streams);
    if (!done.decoder) return receive(std::move(sample));
    if (!receive(sample)) return false;
    is_decoding_ = true;
    all_taken_ = true;
    done.decoder->decode(sample, *this);
    return all_taken_;
  }

  bool receive(Sample sample) override {
    auto& done = state_.done[sample.header.stream];
    const double time_s = to_seconds(sample.header.sample_time - kFirstSample);
    if (done.samples++ == 0) done.begin_s = time_s;
    if ((sample.header.status & ~kStatusDuplicate) != kStatusOk) ++done.invalid;
    done.end_s = time_s;
    done.feed = feed_;
    done.is_decoded = is_decoding_;
    duration_s_ = std::max(duration_s_, time_s);
    const bool taken = sink_.receive(std::move(sample));
    all_taken_ = all_taken_ && taken;
    return taken;
  }

  double duration_s() const { return duration_s_; }

 private:
  State& state_;
  SampleSink& sink_;
  std::size_t feed_ = 0;
  bool is_decoding_ = false;
  bool all_taken_ = true;
  double duration_s_ = 0;
};

ImportReport SessionImport::report() const {
  ImportReport report;
  for (std::size_t i = 0; i < state_->feeds.size(); ++i) {
    const auto told = state_->feeds[i]->describe();
    for (auto stream : told) {
      const auto& done = state_->done[*state_->streams->find(stream.topic)];
      stream.samples = done.samples;
      stream.begin_s = done.begin_s;
      stream.end_s = done.end_s;
      if (done.decoder) {
        const auto& counters = done.decoder->counters();
        stream.remarks.push_back(fmt::format("decoded: {} records, {} damaged, {} bytes passed over", counters.records,
                                             counters.bad_records, counters.skipped_bytes));
      }
      report.streams.push_back(std::move(stream));
    }
    for (const auto& [id, done] : state_->done) {
      if (!done.is_decoded || done.feed != i) continue;
      const double span_s = done.end_s - done.begin_s;
      report.streams.push_back({.topic = state_->streams->info(id).topic,
                                .path = told.front().path,
                                .samples = done.samples,
                                .invalid_samples = done.invalid,
                                .rate_hz = span_s > 0 ? static_cast<double>(done.samples - 1) / span_s : 0,
                                .begin_s = done.begin_s,
                                .end_s = done.end_s});
    }
  }
  return report;
}

Result<ImportReport> SessionImport::run(SampleSink& sink, const std::stop_token& stop,
                                        const std::function<void(double)>& progress) {
  constexpr std::uint64_t kProgressStep = 256;
  Counter counter(*state_, sink);
  std::uint64_t taken = 0;
  bool was_stopped = false;
  while (!was_stopped) {
    const auto next = state_->next_feed();
    if (!next) return next.error();
    if (!*next) break;
    if (!counter.take(**next, state_->feeds[**next]->take())) {
      return Error{ErrorCode::io, "the session takes no more samples: see what its recorder says"};
    }
    if (progress && (taken < kProgressStep || taken % kProgressStep == 0)) {
      double share = 0;
      for (const auto& feed : state_->feeds) share += feed->share();
      progress(std::min(1.0, share / static_cast<double>(state_->feeds.size())));
    }
    ++taken;
    was_stopped = stop.stop_requested();
  }
  sink.flush();
  auto told = report();
  told.duration_s = counter.duration_s();
  told.was_stopped = was_stopped;
  return told;
}

}  // namespace roseau::recorder
