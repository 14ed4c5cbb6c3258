#include "recorder/tools/selection/selection.h"

#include <fmt/format.h>
#include <fnmatch.h>

#include <algorithm>
#include <charconv>
#include <cmath>

#include "recorder/format/topics.h"
#include "recorder/tools/selection/civil_time.h"

namespace roseau::recorder {

namespace {

constexpr std::int64_t kLeastHostNumber_ns = 1'000'000'000;
constexpr double kMostSeconds = 9e9;  // nanoseconds of them fit

template <class T>
std::optional<T> number_from(std::string_view text) {
  T value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  return value;
}

struct Span {
  HostTime begin;
  HostTime end;
  std::optional<Duration> utc_minus_host_time;

  std::string text() const {
    std::string words = fmt::format("{:.3f} s long", to_seconds(end - begin));
    if (utc_minus_host_time) {
      words += fmt::format(", from {} to {}", utc_text(to_ns(begin + *utc_minus_host_time), 3),
                           utc_text(to_ns(end + *utc_minus_host_time), 3));
    }
    return words;
  }
};

Result<HostTime> resolve(const std::string& text, const char* option, const Span& span) {
  const auto point = parse_time_point(text);
  if (!point) return point.error().with_context(option);
  switch (point->axis) {
    case TimePoint::Axis::session:
      return span.begin + point->since;
    case TimePoint::Axis::host:
      return HostTime{point->since};
    case TimePoint::Axis::utc:
      break;
  }
  if (!span.utc_minus_host_time) {
    return Error{ErrorCode::invalid_argument, fmt::format("{}: this session does not know civil time (it has no "
                                                          "utc_minus_host_time_ns): give seconds from its start",
                                                          option)};
  }
  return HostTime{point->since - *span.utc_minus_host_time};
}

struct Times {
  std::optional<HostTime> from;
  std::optional<HostTime> to;
};

Result<Times> resolve_times(const SelectionOptions& options, const Span& span) {
  Times times;
  if (options.from) {
    const auto from = resolve(*options.from, "--from", span);
    if (!from) return from.error();
    times.from = *from;
  }
  if (options.to) {
    const auto to = resolve(*options.to, "--to", span);
    if (!to) return to.error();
    times.to = *to;
  }
  if (!options.seconds) return times;
  if (!(*options.seconds > 0 && *options.seconds < kMostSeconds)) {
    return Error{ErrorCode::invalid_argument, fmt::format("--for: {} is no length of time", *options.seconds)};
  }
  if (times.from && times.to) {
    return Error{ErrorCode::invalid_argument, "--for: together with both --from and --to it says too much: leave one out"};
  }
  const Duration length = from_seconds(*options.seconds);
  if (times.to) {
    times.from = *times.to - length;
  } else {
    times.to = times.from.value_or(span.begin) + length;
  }
  return times;
}

Result<void> select_times(const SelectionOptions& options, const Span& span, Selection& selection) {
  const auto times = resolve_times(options, span);
  if (!times) return times.error();
  const HostTime from = times->from.value_or(span.begin);
  const HostTime to = times->to.value_or(span.end + Duration{1});
  if (from > span.end || to <= span.begin) {
    return Error{ErrorCode::invalid_argument,
                 fmt::format("the wanted part, {}, lies outside of the session, which is {}",
                             times->from ? fmt::format("from {:.3f} s", to_seconds(from - span.begin))
                                         : fmt::format("to {:.3f} s", to_seconds(to - span.begin)),
                             span.text())};
  }
  if (from >= to) {
    return Error{ErrorCode::invalid_argument,
                 fmt::format("nothing lies between --from ({:.3f} s after the session's start) and --to ({:.3f} s)",
                             to_seconds(from - span.begin), to_seconds(to - span.begin))};
  }
  if (times->from) selection.first_time_ns = mcap::log_time_from(*times->from);
  if (times->to) selection.last_time_ns = mcap::log_time_from(*times->to - Duration{1});
  return {};
}

Result<void> select_channels(const SelectionOptions& options, const mcap::Catalog& catalog, Selection& selection) {
  const auto any_matches = [](const std::vector<std::string>& globs, const std::string& topic) {
    return std::ranges::any_of(globs, [&topic](const std::string& glob) { return matches(glob, topic); });
  };
  std::string topics;
  for (const auto& [id, channel] : catalog.channels()) topics += (topics.empty() ? "" : ", ") + channel.topic;
  for (const auto* globs : {&options.topics, &options.without}) {
    for (const std::string& glob : *globs) {
      const bool is_used =
          std::ranges::any_of(catalog.channels(), [&glob](const auto& entry) { return matches(glob, entry.second.topic); });
      if (is_used) continue;
      return Error{ErrorCode::not_found, fmt::format("{} '{}' is no topic of this session, which holds {}",
                                                     globs == &options.topics ? "--topic" : "--without", glob, topics)};
    }
  }
  for (const auto& [id, channel] : catalog.channels()) {
    const bool wanted = options.topics.empty() || any_matches(options.topics, channel.topic);
    if (wanted && !any_matches(options.without, channel.topic)) selection.channels.push_back(id);
  }
  if (!catalog.channels().empty() && selection.channels.empty()) {
    return Error{ErrorCode::invalid_argument, "--topic and --without leave nothing of the session, which holds " + topics};
  }
  return {};
}

}  // namespace

Result<TimePoint> parse_time_point(std::string_view text) {
  if (const auto utc_ns = parse_utc(text)) return TimePoint{TimePoint::Axis::utc, Duration{*utc_ns}};
  const bool says_ns = text.ends_with("ns");
  if (const auto host_ns = number_from<std::int64_t>(says_ns ? text.substr(0, text.size() - 2) : text);
      host_ns && (says_ns || *host_ns >= kLeastHostNumber_ns)) {
    return TimePoint{TimePoint::Axis::host, Duration{*host_ns}};
  }
  const auto seconds = number_from<double>(text.ends_with('s') && !says_ns ? text.substr(0, text.size() - 1) : text);
  if (seconds && std::abs(*seconds) < kMostSeconds) return TimePoint{TimePoint::Axis::session, from_seconds(*seconds)};
  return Error{ErrorCode::invalid_argument,
               fmt::format("'{}' is no time: give seconds from the start (12.5), UTC (2026-11-22T15:46:08Z) or host "
                           "nanoseconds (123456789012ns)",
                           text)};
}

bool Selection::holds_channel(std::uint16_t id) const { return std::ranges::binary_search(channels, id); }

bool matches(const std::string& glob, const std::string& topic) { return ::fnmatch(glob.c_str(), topic.c_str(), 0) == 0; }

Result<Selection> select(const SelectionOptions& options, const mcap::FileIndex& index,
                         std::optional<Duration> utc_minus_host_time) {
  Selection selection;
  const Span span{mcap::host_time_from(index.statistics.message_start_time_ns),
                  mcap::host_time_from(index.statistics.message_end_time_ns), utc_minus_host_time};
  if (options.has_times()) {
    if (auto times = select_times(options, span, selection); !times) return times.error();
  }
  if (auto channels = select_channels(options, index.catalog, selection); !channels) return channels.error();
  return selection;
}

}  // namespace roseau::recorder
