// When the entries of a log arrived: from what its logger noted. Two passes: observe() every entry, then time_of() each again.
//
//   milliseconds with GPS   the logger's milliseconds, unwrapped, laid on GPS time. In every ten minutes the entry counts that
//                           trails its GPS second least (later ones only waited longer in the logger); between these the clock
//                           is interpolated. A fix is required where there is any.
//   milliseconds alone      since the logger's start: no civil time.
//   stamps                  taken as they are. Times of day gain a day at midnight; their date is the first that a sentence
//                           tells. Entries that share a stamp are spread evenly up to the next.
//   sentences (ZDA, RMC)    what follows one arrived at its time, spread evenly up to the next.
//   a rate                  where there is nothing else.
//
// Times never go back: a step back of up to kMostStepBack is held, a larger one is an Error.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/result.h"
#include "core/time.h"
#include "recorder/tools/import/log_reader.h"

namespace roseau::recorder {

class LogClock {
 public:
  static constexpr Duration kMostStepBack = std::chrono::seconds{2};
  /// Most entries that may share a stamp and be spread.
  static constexpr std::size_t kMostSpread = 4096;

  enum class Kind : std::uint8_t { none, gps, millis, stamps, sentences, rate };

  /// `sentence_time`: what this entry says about civil time (ZDA, RMC), if it does.
  void observe(const LogEntry& entry, std::optional<Duration> sentence_time);

  /// Ends the first pass. Error: no times and no rate, or times that go back, naming the file.
  Result<void> settle(std::optional<double> rate_hz, const std::string& source_name);

  /// Second pass, in the same order: the entry's own time, on an axis that `civil()` tells of. Entries that share one are to be
  /// spread by whoever asks (spread()).
  Duration time_of(const LogEntry& entry, std::optional<Duration> sentence_time);

  Kind kind() const { return kind_; }
  /// Times are since 1970 (UTC); else since something else.
  bool is_civil() const { return is_civil_; }
  Duration first_time() const { return first_time_; }
  /// Begins the second pass; settle() did it once.
  void begin_pass();
  /// The smallest step between times: the stamps' resolution.
  Duration resolution() const { return resolution_; }
  std::uint64_t entries() const { return entries_; }
  std::vector<std::string> remarks() const;

 private:
  struct Knot {
    double millis = 0;
    Duration offset{0};  // GPS time - milliseconds
  };
  /// From one start of the logger to the next.
  struct Segment {
    std::vector<Knot> knots;
    double begin_millis = 0;
    double end_millis = 0;
  };

  /// Steps to the entry's segment and says its milliseconds there, unwrapped. True in `is_new`: the logger started again.
  double unwrap(std::uint32_t millis, bool& is_new);
  void observe_millis(const LogEntry& entry);
  void observe_plain(const LogEntry& entry, std::optional<Duration> sentence_time);
  void finish_block();
  static Duration on_gps(const Segment& segment, double millis);
  Result<void> settle_segments(const std::string& source_name);
  Result<void> settle_plain(std::optional<double> rate_hz, const std::string& source_name);

  /// The entry's stamp with the days that have passed since the first; nothing when it has none.
  std::optional<Duration> stamp_of(const LogEntry& entry);

  Kind kind_ = Kind::none;
  bool is_civil_ = false;
  double rate_hz_ = 0;

  // Of the pass that is going on.
  std::uint64_t entries_ = 0;
  std::optional<std::uint32_t> last_millis_;
  double wrapped_millis_ = 0;
  std::size_t segment_ = 0;
  std::optional<Duration> last_time_of_day_;
  Duration days_{0};  // midnights passed
  std::optional<Duration> last_plain_;
  std::optional<Duration> last_given_;

  // What the first pass found.
  struct Steps {
    std::uint64_t entries = 0;  // that told a time
    std::optional<Duration> first;
    Duration last{0};
    Duration smallest{0};
    Duration largest_back{0};
    std::uint64_t back = 0;
    void add(Duration time);
  };
  std::vector<Segment> segments_;
  std::vector<Knot> block_;
  std::optional<Duration> last_gps_;
  std::uint64_t with_millis_ = 0;
  bool has_knots_ = false;
  Steps stamps_;
  Steps sentences_;
  bool has_time_of_day_ = false;
  std::optional<Duration> date_;  // to be added to times of day
  Duration first_time_{0};
  Duration resolution_{0};
};

}  // namespace roseau::recorder
