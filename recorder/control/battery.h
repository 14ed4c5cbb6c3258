// What the machine runs on, as Linux says it in /sys/class/power_supply.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

namespace roseau::recorder {

struct Power {
  std::optional<double> battery_percent;  // all batteries of the machine together; nothing: it has none
  bool on_battery = false;                // discharging, and no mains
};

/// Batteries of mice and the like do not count. A folder that is not there: no battery.
Power read_power(const std::filesystem::path& folder = "/sys/class/power_supply");

struct BatteryVerdict {
  enum class Kind : std::uint8_t { well, warn, stop };
  Kind kind = Kind::well;
  std::string message;
};

/// Warns while on battery and at most 10 points above the limit; at the limit, recording is to stop. Stays so until the machine
/// is on mains again or 5 points above the limit.
class BatteryGuard {
 public:
  /// `stop_percent` 0: never.
  explicit BatteryGuard(double stop_percent) : stop_percent_(stop_percent) {}
  BatteryVerdict judge(const Power& power);

 private:
  const double stop_percent_;
  bool is_low_ = false;
};

}  // namespace roseau::recorder
