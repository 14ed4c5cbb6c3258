#include "recorder/control/battery.h"

#include <fmt/format.h>

#include <fstream>

namespace roseau::recorder {

namespace {

constexpr double kWarnAbove_percent = 10;
constexpr double kWellAbove_percent = 5;

std::string word_in(const std::filesystem::path& file) {
  std::ifstream in(file);
  std::string word;
  std::getline(in, word);
  return word;
}

std::optional<double> number_in(const std::filesystem::path& file) {
  std::ifstream in(file);
  double number = 0;
  return in >> number ? std::optional(number) : std::nullopt;
}

}  // namespace

Power read_power(const std::filesystem::path& folder) {
  double percent = 0;
  int batteries = 0;
  bool discharging = false;
  bool on_mains = false;
  std::error_code error;
  for (std::filesystem::directory_iterator entry(folder, error), end; !error && entry != end; entry.increment(error)) {
    const auto& supply = entry->path();
    const std::string type = word_in(supply / "type");
    if (type == "Mains" || type == "USB") on_mains = on_mains || number_in(supply / "online").value_or(0) > 0;
    if (type != "Battery" || word_in(supply / "scope") == "Device") continue;
    const auto capacity = number_in(supply / "capacity");
    if (!capacity) continue;
    percent += *capacity;
    ++batteries;
    discharging = discharging || word_in(supply / "status") == "Discharging";
  }
  Power power;
  if (batteries > 0) power.battery_percent = percent / batteries;
  power.on_battery = discharging && !on_mains;
  return power;
}

BatteryVerdict BatteryGuard::judge(const Power& power) {
  if (stop_percent_ <= 0 || !power.battery_percent || !power.on_battery) {
    is_low_ = false;
    return {};
  }
  const double percent = *power.battery_percent;
  is_low_ = percent <= stop_percent_ || (is_low_ && percent < stop_percent_ + kWellAbove_percent);
  if (is_low_) {
    return {BatteryVerdict::Kind::stop,
            fmt::format(
                "the battery is at {:.0f} %: recording has stopped, the file is whole. Connect the mains or a charged battery",
                percent)};
  }
  if (percent <= stop_percent_ + kWarnAbove_percent) {
    return {BatteryVerdict::Kind::warn,
            fmt::format("the battery is at {:.0f} %: recording stops at {:.0f} %. Connect the mains or a charged battery",
                        percent, stop_percent_)};
  }
  return {};
}

}  // namespace roseau::recorder
