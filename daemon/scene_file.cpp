#include "daemon/scene_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <map>
#include <memory>
#include <string_view>
#include <utility>
#include <vector>

#include "core/decoder.h"
#include "core/wind_geometry.h"
#include "daemon/host_clock.h"
#include "daemon/text_file.h"
#include "drivers/wire/make_decoder.h"
#include "replay/session_source.h"
#include "structure/tree/simplify.h"
#include "structure/tree/tree_file.h"
#include "synthesis/wind/recorded_wind.h"

namespace roseau::daemon {

namespace {

constexpr auto kReadTimeout = std::chrono::milliseconds(100);

/// The records of one anemometer of a session, decoded, in the world's axes.
class WindSink final : public SampleSink {
 public:
  WindSink(StreamTable& streams, std::string topic) : streams_(streams), topic_(std::move(topic)) {}

  bool receive(Sample sample) override {
    const StreamInfo& info = streams_.info(sample.header.stream);
    if (sample.kind() == SampleKind::raw_bytes) {
      auto [decoder, is_new] = decoders_.try_emplace(sample.header.stream);
      if (is_new) decoder->second = wire::make_decoder(info, streams_);
      if (decoder->second) decoder->second->decode(sample, *this);
    } else if (const auto* wind = std::get_if<WindSample>(&sample.payload);
               wind != nullptr && !info.topic.starts_with("/truth")) {
      take(info, sample.header.sample_time, *wind);
    }
    return true;
  }

  const std::string& topic() const { return topic_; }
  const std::vector<Vec3>& samples_mps() const { return samples_mps_; }
  double rate_hz() const {
    const double span_s = to_seconds(last_ - first_);
    return span_s > 0 ? static_cast<double>(samples_mps_.size() - 1) / span_s : 0;
  }

 private:
  void take(const StreamInfo& info, HostTime time, const WindSample& wind) {
    if (topic_.empty()) topic_ = info.topic;
    if (info.topic != topic_) return;
    const auto metadata = [&info](const char* key) {
      const auto found = info.metadata.find(key);
      return found == info.metadata.end() ? std::string() : found->second;
    };
    const std::string offset = metadata("north_offset_deg");
    const auto axes = wind_axes_from_string(metadata("axes"));
    if (samples_mps_.empty()) first_ = time;
    last_ = time;
    samples_mps_.push_back(synthesis::velocity_in_world_mps(wind, offset.empty() ? 0 : std::strtod(offset.c_str(), nullptr),
                                                            axes ? *axes : WindAxes::gill_spar));
  }

  StreamTable& streams_;
  std::string topic_;
  std::map<StreamId, std::unique_ptr<Decoder>> decoders_;
  std::vector<Vec3> samples_mps_;
  HostTime first_;
  HostTime last_;
};

Result<void> read_recorded_wind(const std::filesystem::path& path, synthesis::RecordingScene& recording) {
  auto source = replay::SessionSource::open_file(
      path, {.speed = std::numeric_limits<double>::infinity(), .loop = false, .now = host_now});
  if (!source) return source.error().with_context("scene: wind.recording");
  StreamTable streams;
  if (auto opened = (*source)->open(streams); !opened) return opened.error().with_context("scene: wind.recording");
  WindSink sink(streams, recording.topic);
  while (true) {
    const auto status = (*source)->read(sink, kReadTimeout);
    if (!status) return status.error().with_context("scene: wind.recording");
    if (*status == ReadStatus::finished) break;
  }
  if (sink.samples_mps().size() < 2) {
    return Error{ErrorCode::not_found, fmt::format("scene: wind.recording: {} holds no wind{}", path.string(),
                                                   recording.topic.empty() ? "" : " on topic " + recording.topic)};
  }
  recording.samples_mps = sink.samples_mps();
  recording.rate_hz = sink.rate_hz();
  return {};
}

}  // namespace

Result<synthesis::Scene> load_scene(const std::filesystem::path& path, std::optional<std::uint64_t> seed) {
  synthesis::Scene scene;
  if (!path.empty()) {
    const auto text = read_text_file(path);
    if (!text) return text.error().with_context("scene");
    auto read = synthesis::scene_from_toml(*text, path.string());
    if (!read) return read.error();
    scene = std::move(*read);
  }
  if (seed) scene.seed = *seed;
  if (scene.tree.kind == "file") {
    const auto tree = structure::read_tree(path.parent_path() / scene.tree.file);
    if (!tree) return tree.error().with_context("scene: tree");
    auto simple = structure::simplify(tree->tree, {.node_budget = scene.tree.node_limit});
    if (!simple) return simple.error().with_context("scene: tree.node_limit");
    scene.tree.model = std::move(simple->tree);
  }
  if (!scene.wind.recording.file.empty()) {
    if (auto read = read_recorded_wind(path.parent_path() / scene.wind.recording.file, scene.wind.recording); !read) {
      return read.error();
    }
  }
  return scene;
}

std::string scene_config_text() {
  // The wind that pushes a target to the right of the pictures comes from the west.
  return "name = \"simulation\"\n\n[estimation]\nimage_plane_direction_deg = 270.0\n";
}

}  // namespace roseau::daemon
