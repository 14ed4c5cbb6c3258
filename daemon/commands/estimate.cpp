#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <string_view>
#include <vector>

#include "daemon/commands.h"
#include "daemon/commands/failure.h"
#include "daemon/commands/replay_plan.h"
#include "daemon/host_clock.h"
#include "daemon/topic_names.h"
#include "estimation/free_decay.h"
#include "replay/session_source.h"

namespace roseau::daemon {

namespace {

using estimation::FrequencyBand;

Result<FrequencyBand> parse_band(const std::string& text) {
  const auto colon = text.find(':');
  FrequencyBand band;
  const auto number = [](std::string_view part, double& value) {
    const auto [end, error] = std::from_chars(part.data(), part.data() + part.size(), value);
    return error == std::errc{} && end == part.data() + part.size();
  };
  const bool readable = colon != std::string::npos && number(std::string_view(text).substr(0, colon), band.min_hz) &&
                        number(std::string_view(text).substr(colon + 1), band.max_hz);
  if (!readable || !(band.min_hz > 0) || !(band.max_hz > band.min_hz)) {
    return Error{ErrorCode::invalid_argument, "--band " + text + ": give LOW:HIGH in Hz, such as 0.15:0.35"};
  }
  return band;
}

struct Series {
  std::vector<double> x;
  std::vector<double> y;
  HostTime first;
  HostTime last;
  double rate_hz() const { return static_cast<double>(x.size() - 1) / to_seconds(last - first); }
};

/// Every displacement series among the inputs, by target.
class SeriesSink : public SampleSink {
 public:
  explicit SeriesSink(const StreamTable& streams) : streams_(streams) {}
  bool receive(Sample sample) override {
    const auto* displacement = std::get_if<Displacement>(&sample.payload);
    const std::string& topic = streams_.info(sample.header.stream).topic;
    const bool is_truth = topic.starts_with("/truth");
    if (displacement == nullptr || is_truth) return true;
    constexpr std::string_view kImported = "/displacement/";
    const std::string name =
        topic.starts_with(kImported) ? topic.substr(kImported.size()) : target_of_topic(topic, "displacement").value_or(topic);
    Series& series = series_[name];
    if (series.x.empty()) series.first = sample.header.sample_time;
    series.last = sample.header.sample_time;
    series.x.push_back(displacement->x);
    series.y.push_back(displacement->y);
    return true;
  }
  const std::map<std::string, Series>& series() const { return series_; }

 private:
  const StreamTable& streams_;
  std::map<std::string, Series> series_;
};

Result<std::map<std::string, Series>> read_series(const std::filesystem::path& file) {
  auto source = replay::SessionSource::open_file(
      file, {.speed = std::numeric_limits<double>::infinity(), .loop = false, .now = host_now});
  if (!source) return source.error();
  StreamTable streams;
  if (auto opened = (*source)->open(streams); !opened) return opened.error();
  SeriesSink sink(streams);
  for (;;) {
    const auto status = (*source)->read(sink, std::chrono::milliseconds(100));
    if (!status) return status.error();
    if (*status == ReadStatus::finished) break;
  }
  if (sink.series().empty()) {
    return Error{ErrorCode::not_found,
                 file.string() + " holds no displacement series: import one with roseau import --displacement FILE --rate HZ"};
  }
  return sink.series();
}

nlohmann::ordered_json decay_json(const estimation::FreeDecay& decay) {
  return {{"natural_frequency_hz", decay.natural_frequency_hz},
          {"natural_frequency_sd_hz", decay.natural_frequency_sd_hz},
          {"damping_ratio", decay.damping_ratio},
          {"damping_ratio_sd", decay.damping_ratio_sd},
          {"amplitude", decay.amplitude},
          {"spectral_peak_hz", decay.spectral_peak_hz},
          {"resolution_hz", decay.resolution_hz},
          {"start_s", decay.start_s},
          {"duration_s", decay.duration_s},
          {"explained", decay.explained}};
}

std::string decay_text(const std::string& name, const estimation::FreeDecay& decay) {
  return fmt::format(
      "{}: natural frequency {:.4f} +- {:.4f} Hz, damping ratio {:.4f} +- {:.4f}\n"
      "  spectral peak {:.4f} Hz, resolution {:.4f} Hz; decay of {:.1f} s from {:.1f} s on, {:.1f} % explained\n",
      name, decay.natural_frequency_hz, decay.natural_frequency_sd_hz, decay.damping_ratio, decay.damping_ratio_sd,
      decay.spectral_peak_hz, decay.resolution_hz, decay.duration_s, decay.start_s, decay.explained * 100);
}

/// The axis that moves more.
const std::vector<double>& main_axis(const Series& series) {
  const auto spread = [](const std::vector<double>& values) {
    const auto [least, most] = std::ranges::minmax(values);
    return most - least;
  };
  return spread(series.y) > spread(series.x) ? series.y : series.x;
}

int estimate_free_decay(const EstimateArguments& arguments, const FrequencyBand& band) {
  const auto all = read_series(arguments.file);
  if (!all) return failed(all.error());
  int status = kExitOk;
  nlohmann::ordered_json json;
  for (const auto& [name, series] : *all) {
    if (series.x.size() < 2) {
      status = failed(Error{ErrorCode::invalid_argument, name + ": a single value is no series"});
      continue;
    }
    const auto decay = estimation::fit_free_decay(main_axis(series), series.rate_hz(), band);
    if (!decay) {
      status = failed(decay.error().with_context(name));
    } else if (arguments.json) {
      json["targets"][name] = decay_json(*decay);
    } else {
      fmt::print("{}", decay_text(name, *decay));
    }
  }
  if (arguments.json) fmt::print("{}\n", json.dump(2));
  return status;
}

}  // namespace

int estimate_command(const EstimateArguments& arguments) {
  std::optional<FrequencyBand> band;
  if (arguments.band_hz) {
    const auto parsed = parse_band(*arguments.band_hz);
    if (!parsed) {
      failed(parsed.error());
      return kExitUsage;
    }
    band = *parsed;
  }
  if (arguments.free_decay) return estimate_free_decay(arguments, band.value_or(FrequencyBand{}));

  ReplayArguments replay;
  replay.file = arguments.file;
  replay.speed = std::numeric_limits<double>::infinity();
  replay.session.headless = true;
  replay.session.json = arguments.json;
  auto plan = make_replay_plan(replay);
  if (!plan) return failed(plan.error());
  if (band) {
    plan->config.estimation.identification.min_frequency_hz = band->min_hz;
    plan->config.estimation.identification.max_frequency_hz = band->max_hz;
  }
  plan->record_file = arguments.output;
  return run_session(std::move(*plan));
}

}  // namespace roseau::daemon
