#include "recorder/tools/import/import_session.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>
#include <utility>

#include "recorder/tools/import/import_feed.h"

namespace roseau::recorder {

namespace {

// Not 0: a time of 0 means "none" in session files.
constexpr HostTime kFirstSample{std::chrono::seconds{1}};

using Feeds = std::vector<std::unique_ptr<ImportFeed>>;

template <class Items>
Result<void> add_feeds(const Items& items, Feeds& feeds) {
  for (const auto& item : items) {
    auto feed = make_feed(item);
    if (!feed) return feed.error();
    feeds.push_back(std::move(*feed));
  }
  return {};
}

Result<void> check_topics(const Feeds& feeds, const ImportPlan& plan) {
  std::set<std::string> topics;
  for (const auto& video : plan.videos) {
    if (!topics.insert(video.topic).second) {
      return Error{ErrorCode::invalid_argument,
                   fmt::format("topic {} is given to two files: give one another name", video.topic)};
    }
  }
  for (std::size_t i = plan.videos.size(); i < feeds.size(); ++i) {
    const auto topic = feeds[i]->describe().topic;
    if (!topics.insert(topic).second) {
      return Error{ErrorCode::invalid_argument, fmt::format("topic {} is given to two files: give one another name", topic)};
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

struct SessionImport::State {
  Feeds feeds;
  std::vector<ImportReport::Stream> done;  // per feed: what has been handed on
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

Result<SessionImport> SessionImport::prepare(const ImportPlan& plan, StreamTable& streams) {
  auto state = std::make_unique<State>();
  auto& feeds = state->feeds;
  if (auto added = add_feeds(plan.videos, feeds); !added) return added.error();
  if (auto added = add_feeds(plan.sonics, feeds); !added) return added.error();
  if (auto added = add_feeds(plan.displacements, feeds); !added) return added.error();
  if (feeds.empty())
    return Error{ErrorCode::invalid_argument, "nothing to import: name a video, a sonic file or a displacement series"};
  if (auto checked = check_topics(feeds, plan); !checked) return checked.error();

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
  state->done.resize(feeds.size());
  return SessionImport(std::move(state));
}

Result<ImportReport> SessionImport::run(SampleSink& sink, const std::stop_token& stop,
                                        const std::function<void(double)>& progress) {
  std::uint64_t expected = 0;
  for (const auto& feed : state_->feeds) expected += feed->expected_samples();
  const std::uint64_t progress_step = std::max<std::uint64_t>(1, expected / 200);

  ImportReport report;
  std::uint64_t taken = 0;
  while (!report.was_stopped) {
    const auto next = state_->next_feed();
    if (!next) return next.error();
    if (!*next) break;
    auto& stream = state_->done[**next];
    Sample sample = state_->feeds[**next]->take();
    const double time_s = to_seconds(sample.header.sample_time - kFirstSample);
    if (stream.samples++ == 0) stream.begin_s = time_s;
    stream.end_s = time_s;
    report.duration_s = std::max(report.duration_s, time_s);
    if (!sink.receive(std::move(sample))) {
      return Error{ErrorCode::io, "the session takes no more samples: see what its recorder says"};
    }
    if (progress && ++taken % progress_step == 0)
      progress(std::min(1.0, static_cast<double>(taken) / static_cast<double>(expected)));
    report.was_stopped = stop.stop_requested();
  }
  sink.flush();
  for (std::size_t i = 0; i < state_->feeds.size(); ++i) {
    auto stream = state_->feeds[i]->describe();
    stream.samples = state_->done[i].samples;
    stream.begin_s = state_->done[i].begin_s;
    stream.end_s = state_->done[i].end_s;
    report.streams.push_back(std::move(stream));
  }
  return report;
}

}  // namespace roseau::recorder
