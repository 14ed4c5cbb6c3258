// Triggers: conditions on what is measured and estimated, watched sample by sample. Pure functions of the samples.
//
//   wind_speed_mps            horizontal wind of an anemometer; size of an accepted estimate
//   gust_mps                  the same, above its own mean over the window
//   displacement_rms          of a target about its mean over the window, in the target's own unit
//   displacement_amplitude    how far a target is from its mean over the window, in the target's own unit
//
// A trigger fires when its quantity has been above the threshold for long enough without a break, and ends when the quantity
// falls below the threshold by more than the hysteresis, or when nothing comes any more.
#pragma once

#include <cstdint>
#include <deque>
#include <optional>
#include <string>
#include <vector>

#include "core/result.h"
#include "core/sample.h"
#include "core/stream.h"
#include "core/time.h"

namespace roseau::recorder {

enum class TriggerQuantity : std::uint8_t { wind_speed_mps, gust_mps, displacement_rms, displacement_amplitude };
std::string_view to_string(TriggerQuantity quantity);
Result<TriggerQuantity> trigger_quantity_from_string(std::string_view name);

struct TriggerOptions {
  std::string name;
  std::string topic;  // of wind samples, wind estimates or displacements
  TriggerQuantity quantity = TriggerQuantity::wind_speed_mps;
  double above = 0;                            // the quantity's unit
  double hysteresis = 0;                       // the same; 0: ends as soon as it is not above any more
  Duration for_at_least{0};                    // above for this long before it fires, sample time
  Duration window = std::chrono::seconds(30);  // of means and RMS; all of it must have been seen before they count
  Duration rearm{0};                           // from one firing to the next, at least
};

struct TriggerEvent {
  bool begins = true;  // false: it has ended
  HostTime at;         // log time of the sample that did it
  std::string name;
  std::string reason;  // "gust_mps 6.2 on /sonic/wind, above 5"
};

/// Mean and mean square of the newest values, by their times; the same values in the same order give the same bits.
class SlidingMoments {
 public:
  explicit SlidingMoments(Duration window) : window_(window) {}
  void add(HostTime time, double value);
  void clear() { *this = SlidingMoments(window_); }
  /// A whole window was seen, without a break as long as it. A mean over part of a sway would be off.
  bool is_settled() const;
  double mean() const;
  double variance() const;

 private:
  struct Entry {
    HostTime time;
    double value = 0;
  };
  void sum_anew();

  Duration window_;
  std::deque<Entry> entries_;
  HostTime begin_;     // of what was seen without a break
  double origin_ = 0;  // near the mean: sums of squares lose nothing to a large offset
  double sum_ = 0;
  double square_sum_ = 0;
  std::size_t until_summed_anew_ = 1;
};

/// One condition. One thread at a time.
class Trigger {
 public:
  explicit Trigger(TriggerOptions options) : options_(std::move(options)), x_(options_.window), y_(options_.window) {}

  const TriggerOptions& options() const { return options_; }

  /// A sample of its topic. An event when the trigger fires or ends with it.
  std::optional<TriggerEvent> see(const Sample& sample, HostTime log_time);

  /// Log time has come to `now`: ends when nothing usable has come for a while.
  std::optional<TriggerEvent> tick(HostTime now);

 private:
  std::optional<double> value_of(const Sample& sample);
  std::optional<TriggerEvent> judge(double value, HostTime sample_time, HostTime log_time);
  TriggerEvent end(HostTime at, const std::string& why);

  TriggerOptions options_;
  SlidingMoments x_;
  SlidingMoments y_;
  bool is_on_ = false;
  std::optional<HostTime> above_since_;  // sample time
  std::optional<HostTime> last_fired_;   // log time
  HostTime last_seen_;                   // log time of the last usable value
};

/// All triggers of a session. One thread at a time.
class TriggerWatch {
 public:
  TriggerWatch(const std::vector<TriggerOptions>& triggers, const StreamTable& streams);

  /// Any sample; events in the order of the triggers.
  std::vector<TriggerEvent> see(const Sample& sample, HostTime log_time);
  bool empty() const { return triggers_.empty(); }

 private:
  std::vector<Trigger> triggers_;
  const StreamTable& streams_;
};

}  // namespace roseau::recorder
