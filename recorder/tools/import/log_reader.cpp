#include "recorder/tools/import/log_reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <chrono>
#include <cmath>
#include <utility>

#include "recorder/tools/import/record_times.h"
#include "recorder/tools/import/text_table.h"

namespace roseau::recorder {

namespace {

constexpr std::size_t kBlockBytes = 16384;
constexpr std::size_t kRecordBytes = 148;
constexpr std::size_t kTextOffset = 20;
constexpr std::uint32_t kMostRecords = 110;
constexpr double kLargestLatitude_deg = 90;

template <class Number>
std::optional<Number> whole_number(std::string_view text) {
  Number value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return !text.empty() && error == std::errc{} && end == text.data() + text.size() ? std::optional(value) : std::nullopt;
}

bool is_digit(char c) { return c >= '0' && c <= '9'; }

// "12:34:56.78"
std::optional<Duration> time_of_day(std::string_view text) {
  if (text.size() < 8 || text[2] != ':' || text[5] != ':') return std::nullopt;
  // A day's stamps are those of a date too.
  const auto stamp = parse_time_stamp(fmt::format("1970-01-01 {}", text));
  return stamp;
}

bool is_separator(char c) { return c == ' ' || c == ',' || c == ';' || c == '\t'; }

std::string_view take_token(std::string_view& text) {
  const auto* end = std::ranges::find_if(text, is_separator);
  const auto token = text.substr(0, static_cast<std::size_t>(end - text.begin()));
  text.remove_prefix(std::min(token.size() + 1, text.size()));
  return token;
}

// Takes a stamp off `line`; leaves it alone when there is none.
std::optional<LogEntry::Stamp> take_stamp(std::string_view& line) {
  auto rest = line;
  const bool has_brackets = rest.starts_with('[');
  if (has_brackets) {
    const auto close = rest.find(']');
    if (close == std::string_view::npos) return std::nullopt;
    auto inside = std::string(rest.substr(1, close - 1)) + " ";
    std::string_view text = inside;
    const auto stamp = take_stamp(text);
    if (!stamp || !text.empty()) return std::nullopt;
    line.remove_prefix(close + 1);
    line.remove_prefix(std::min(line.find_first_not_of(' '), line.size()));
    return stamp;
  }
  auto first = std::string(take_token(rest));
  if (rest.empty() && !line.ends_with(' ')) return std::nullopt;  // nothing behind it: no stamp in front of anything
  if (const auto time = time_of_day(first)) {
    line = rest;
    return LogEntry::Stamp{*time, true};
  }
  std::ranges::replace(first, '/', '-');
  const bool is_date = first.size() == 10 && first[4] == '-' && first[7] == '-';
  if (is_date) first += "T" + std::string(take_token(rest));
  const bool has_date = first.size() > 10 && first[4] == '-' && first[7] == '-';
  const bool is_seconds = first.size() >= 9 && std::ranges::all_of(first.substr(0, 9), is_digit);
  if (!has_date && !is_seconds) return std::nullopt;
  const auto stamp = parse_time_stamp(first);
  if (!stamp) return std::nullopt;
  line = rest;
  return LogEntry::Stamp{*stamp, false};
}

// "650,1000.000000,1000.000000,4294967295,0,"
bool take_gps_prefix(std::string_view& line, LogEntry& entry) {
  auto rest = line;
  std::array<std::string_view, 5> fields;
  for (auto& field : fields) {
    const auto comma = rest.find(',');
    if (comma == std::string_view::npos) return false;
    field = rest.substr(0, comma);
    rest.remove_prefix(comma + 1);
  }
  const auto millis = whole_number<std::uint32_t>(fields[0]);
  const auto latitude_deg = whole_number<double>(fields[1]);
  const auto longitude_deg = whole_number<double>(fields[2]);
  const auto time = whole_number<std::uint32_t>(fields[3]);
  const auto date = whole_number<std::uint32_t>(fields[4]);
  if (!millis || !latitude_deg || !longitude_deg || !time || !date) return false;
  entry.millis = millis;
  entry.gps = parse_gps_time(*time, *date);
  entry.has_fix = std::abs(*latitude_deg) <= kLargestLatitude_deg;
  line = rest;
  return true;
}

class TextLog : public LogReader {
 public:
  explicit TextLog(FileReader file) : file_(std::move(file)) {}

  Result<void> rewind() override { return file_.rewind(); }
  Result<bool> next(LogEntry& entry) override {
    while (true) {
      const auto read = file_.line();
      if (!read) return read.error();
      if (!*read) return false;
      auto line = **read;
      if (trimmed(line).empty() || line.starts_with('#')) continue;
      entry = {};
      take_log_prefix(line, entry);
      entry.bytes = line;
      if (file_.line_had_end()) entry.bytes += "\r\n";
      return true;
    }
  }
  double share() const override { return file_.share(); }
  bool was_cut() const override { return !file_.line_had_end(); }

 private:
  FileReader file_;
};

class BlockLog : public LogReader {
 public:
  explicit BlockLog(std::vector<std::string> paths) : paths_(std::move(paths)) {}

  Result<void> rewind() override {
    next_path_ = 0;
    file_.reset();
    pending_.reset();
    left_in_block_ = 0;
    was_cut_ = false;
    return {};
  }
  // The logger took the CR that ended a line away and kept the LF behind it as the first byte of the next record: without one,
  // the next record goes on in the same line. So a record can be given out only when the next is known.
  Result<bool> next(LogEntry& entry) override {
    LogEntry read;
    const auto more = next_record(read);
    if (!more) return more.error();
    if (!*more && !pending_) return false;
    if (!pending_) {
      pending_ = std::move(read);
      return next(entry);
    }
    entry = std::move(*pending_);
    const bool line_ends = !*more || read.bytes.starts_with('\n');
    if (line_ends) entry.bytes += '\r';
    pending_.reset();
    if (*more) pending_ = std::move(read);
    return true;
  }
  double share() const override {
    const auto done = static_cast<double>(next_path_) - (file_ ? 1 - file_->share() : 0);
    return done / static_cast<double>(paths_.size());
  }
  bool was_cut() const override { return was_cut_; }

 private:
  Result<bool> next_record(LogEntry& entry) {
    while (true) {
      if (!file_) {
        if (next_path_ == paths_.size()) return false;
        auto source = open_file(paths_[next_path_]);
        if (!source) return source.error();
        file_.emplace(std::move(*source), paths_[next_path_]);
        ++next_path_;
        left_in_block_ = 0;
      }
      if (left_in_block_ == 0) {
        if (auto begun = begin_block(); !begun) return begun.error();
        continue;
      }
      const auto record = file_->take(kRecordBytes);
      if (!record) return record.error();
      --left_in_block_;
      if (record->size() < kRecordBytes) {
        was_cut_ = true;
        file_.reset();
        continue;
      }
      read_record(*record, entry);
      return true;
    }
  }

  Result<void> begin_block() {
    const auto in_block = file_->position() % kBlockBytes;
    if (in_block != 0) {
      const auto padding = file_->take(kBlockBytes - in_block);
      if (!padding) return padding.error();
    }
    const auto count = file_->take(sizeof(std::uint32_t));
    if (!count) return count.error();
    if (count->size() < sizeof(std::uint32_t)) {
      was_cut_ = was_cut_ || !count->empty();
      file_.reset();
      return {};
    }
    const auto records = number_at(*count, 0);
    if (records > kMostRecords) {
      return Error{ErrorCode::corrupt, fmt::format("{}: byte {}: a block of {} records, where there are at most {}: is this a "
                                                   "TriSonica logger's file?",
                                                   file_->name(), file_->position() - count->size(), records, kMostRecords)};
    }
    left_in_block_ = records;
    return {};
  }

  static std::uint32_t number_at(std::string_view bytes, std::size_t offset) {
    std::uint32_t value = 0;
    for (std::size_t i = 4; i > 0; --i) value = value << 8U | static_cast<std::uint8_t>(bytes[offset + i - 1]);
    return value;
  }

  static void read_record(std::string_view record, LogEntry& entry) {
    const auto latitude_deg = std::bit_cast<float>(number_at(record, 4));
    entry = {};
    entry.millis = number_at(record, 0);
    entry.gps = parse_gps_time(number_at(record, 12), number_at(record, 16));
    entry.has_fix = std::abs(static_cast<double>(latitude_deg)) <= kLargestLatitude_deg;
    const auto text = record.substr(kTextOffset);
    entry.bytes = text.substr(0, text.find('\0'));
  }

  std::vector<std::string> paths_;
  std::size_t next_path_ = 0;
  std::optional<FileReader> file_;
  std::uint32_t left_in_block_ = 0;
  std::optional<LogEntry> pending_;
  bool was_cut_ = false;
};

}  // namespace

std::optional<Duration> parse_gps_time(std::uint32_t time, std::uint32_t date) {
  const auto part = [](std::uint32_t number, std::uint32_t scale) { return static_cast<unsigned>(number / scale % 100); };
  const auto hours = time / 1'000'000;
  const auto minutes = part(time, 10'000);
  const auto seconds = part(time, 100);
  const std::chrono::year_month_day day{std::chrono::year{static_cast<int>(part(date, 1)) + 2000},
                                        std::chrono::month{part(date, 100)}, std::chrono::day{date / 10'000}};
  if (date > 311'299 || hours > 23 || minutes > 59 || seconds > 60 || !day.ok()) return std::nullopt;
  return std::chrono::sys_days(day).time_since_epoch() + std::chrono::hours{hours} + std::chrono::minutes{minutes} +
         std::chrono::seconds{seconds} + std::chrono::milliseconds{10 * part(time, 1)};
}

void take_log_prefix(std::string_view& line, LogEntry& entry) {
  if (take_gps_prefix(line, entry)) return;
  entry.stamp = take_stamp(line);
}

std::unique_ptr<LogReader> open_text_log(FileReader file) { return std::make_unique<TextLog>(std::move(file)); }

Result<std::unique_ptr<LogReader>> open_block_log(std::vector<std::string> paths) {
  ROSEAU_CHECK(!paths.empty());
  std::ranges::sort(paths);
  return std::unique_ptr<LogReader>(std::make_unique<BlockLog>(std::move(paths)));
}

bool looks_like_block_log(std::string_view start) {
  if (start.size() < kTextOffset + 4) return false;
  const auto byte = [&](std::size_t i) { return static_cast<std::uint8_t>(start[i]); };
  return byte(0) >= 1 && byte(0) <= kMostRecords && byte(1) == 0 && byte(2) == 0 && byte(3) == 0;
}

}  // namespace roseau::recorder
