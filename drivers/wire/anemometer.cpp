#include "drivers/wire/anemometer.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "drivers/wire/gill_decoder.h"
#include "drivers/wire/metadata.h"

namespace roseau::wire {

namespace {

constexpr std::string_view kMessages = "messages";

struct ModelName {
  AnemometerModel model;
  std::string_view name;
};
constexpr std::array kModels = {ModelName{AnemometerModel::gill_windsonic, "gill_windsonic"},
                                ModelName{AnemometerModel::gill_windmaster, "gill_windmaster"}};

}  // namespace

std::string_view to_string(AnemometerModel model) {
  const auto* found = std::ranges::find(kModels, model, &ModelName::model);
  ROSEAU_CHECK(found != kModels.end());
  return found->name;
}

Result<AnemometerModel> anemometer_model_from_string(std::string_view name) {
  const auto* found = std::ranges::find(kModels, name, &ModelName::name);
  if (found != kModels.end()) return found->model;
  std::string known;
  for (const auto& model : kModels) known += fmt::format("{}{}", known.empty() ? "" : ", ", model.name);
  return Error{ErrorCode::invalid_argument, fmt::format("anemometer model '{}' is not known; known are {}", name, known)};
}

double default_delay_s(AnemometerModel model, double rate_hz, bool is_averaging) {
  if (model == AnemometerModel::gill_windsonic || is_averaging) return 0.5 / rate_hz;
  const bool samples_at_32_hz = rate_hz == 8 || rate_hz == 16 || rate_hz == 32;
  return samples_at_32_hz ? 1.0 / 32.0 : 1.0 / 20.0;
}

StreamInfo raw_stream(const std::string& device, const AnemometerOptions& options, const std::string& link) {
  const double delay_s = options.delay_s.value_or(default_delay_s(options.model, options.rate_hz, options.is_averaging));
  StreamInfo raw{.topic = "/" + device + std::string(kRawSuffix),
                 .kind = std::string(to_string(SampleKind::raw_bytes)),
                 .role = StreamRole::raw,
                 .device = device,
                 .metadata = {{"model", std::string(to_string(options.model))},
                              {"axes", std::string(to_string(options.axes))},
                              {"north_offset_deg", fmt::format("{}", options.north_offset_deg)},
                              {"rate_hz", fmt::format("{}", options.rate_hz)},
                              {"delay_s", fmt::format("{}", delay_s)},
                              {"framing", std::string(options.keeps_messages_apart ? kMessages : "stream")},
                              {"link", link}}};
  if (options.node != 0) raw.metadata["node"] = std::string(1, options.node);
  return raw;
}

StreamInfo wind_stream(const StreamInfo& raw) { return derived_stream(raw, "wind", SampleKind::wind); }

std::unique_ptr<Decoder> make_anemometer_decoder(const StreamInfo& raw, StreamTable& streams) {
  const auto model = anemometer_model_from_string(metadata_value(raw, "model"));
  if (!model) return nullptr;
  GillDecoder::Options options;
  options.stream = streams.add(wind_stream(raw));
  options.delay = from_seconds(metadata_number(raw, "delay_s", 0));
  options.keeps_messages_apart = metadata_value(raw, "framing") == kMessages;
  if (const auto node = metadata_value(raw, "node"); !node.empty()) options.node = node.front();
  options.dialect = *model == AnemometerModel::gill_windsonic ? kWindSonicDialect : kWindMasterDialect;
  return std::make_unique<GillDecoder>(options);
}

}  // namespace roseau::wire
