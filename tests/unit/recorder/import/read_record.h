// A whole file at once: what its feed hands on.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "recorder/tools/import/displacement_file.h"
#include "recorder/tools/import/import_feed.h"
#include "recorder/tools/import/sonic_file.h"
#include "recorder/tools/import/table_feed.h"
#include "recorder/tools/import/text_table.h"

namespace roseau::recorder {

struct RecordTimes {
  std::vector<Duration> since_first;
  double rate_hz = 0;
  std::size_t missing_rows = 0;
};

/// Places of rows with these stamps, or none.
inline Result<RecordTimes> place_records(std::size_t row_count, const std::vector<Duration>& stamps,
                                         std::optional<double> rate_hz, const std::string& source_name) {
  const auto stamp = [&](std::size_t row) { return stamps.empty() ? std::optional<Duration>() : std::optional(stamps[row]); };
  StampSurvey survey;
  for (std::size_t i = 0; i < row_count; ++i) survey.add(stamp(i));
  auto grid = survey.finish(rate_hz, source_name);
  if (!grid) return grid.error();
  if (grid->kind == RecordGrid::Kind::by_stamp) {
    GridCheck check(*grid);
    for (const auto each : stamps) check.add(each);
    grid = check.finish(rate_hz.has_value(), source_name);
    if (!grid) return grid.error();
  }
  RecordTimes times{.rate_hz = grid->rate_hz, .missing_rows = grid->missing_rows};
  RowPlacer placer(*grid);
  for (std::size_t i = 0; i < row_count; ++i) times.since_first.push_back(placer.next(stamp(i)));
  return times;
}

template <class Payload>
struct Record {
  std::vector<Payload> samples;
  RecordTimes times;
  std::optional<Duration> begin;
  std::uint64_t invalid_samples = 0;
  std::vector<std::string> remarks;
};

/// All samples of a feed, whose times are since the first.
template <class Payload>
Result<Record<Payload>> read_all(ImportFeed& feed) {
  StreamTable streams;
  if (auto started = feed.start(HostTime{}, streams); !started) return started.error();
  Record<Payload> record;
  for (auto time = feed.next_time(); !time || *time; time = feed.next_time()) {
    if (!time) return time.error();
    record.times.since_first.push_back((*time)->time_since_epoch());
    record.samples.push_back(std::get<Payload>(feed.take().payload));
  }
  const auto told = feed.describe().at(0);
  record.times.rate_hz = told.rate_hz;
  record.begin = feed.begin();
  record.invalid_samples = told.invalid_samples;
  record.remarks = told.remarks;
  return record;
}

/// A table, its rows read by what `make_rows` makes for it.
template <class Payload, class MakeRows>
Result<Record<Payload>> read_table(std::unique_ptr<TableReader> table, std::optional<double> rate_hz, const std::string& name,
                                   const MakeRows& make_rows) {
  std::optional<TimeColumns> time;
  auto rows = make_rows(*table, time);
  if (!rows) return rows.error();
  auto feed = make_table_feed(std::move(table), std::move(*rows), time, rate_hz, {}, name);
  if (!feed) return feed.error();
  return read_all<Payload>(**feed);
}

using SonicRecord = Record<WindSample>;
using DisplacementRecord = Record<Displacement>;

inline Result<std::unique_ptr<TextTable>> table_from(std::string_view text, const std::string& name, TableFormat format) {
  return TextTable::open(FileReader(memory_source(std::string(text)), name), format);
}

inline Result<SonicRecord> parse_sonic_file(std::string_view text, const std::string& name, const SonicFileOptions& options,
                                            TableFormat format = TableFormat::automatic) {
  auto table = table_from(text, name, format);
  if (!table) return table.error();
  return read_table<WindSample>(std::move(*table), options.rate_hz, name, [&](const TableReader& opened, auto& time) {
    return make_wind_rows(opened, options, {.topic = "/sonic/wind"}, time);
  });
}

inline Result<DisplacementRecord> parse_displacement_file(std::string_view text, const std::string& name,
                                                          const DisplacementFileOptions& options) {
  auto table = table_from(text, name, TableFormat::automatic);
  if (!table) return table.error();
  return read_table<Displacement>(std::move(*table), options.rate_hz, name, [&](const TableReader& opened, auto& time) {
    return make_displacement_rows(opened, options, {.topic = "/displacement/x"}, time);
  });
}

}  // namespace roseau::recorder
