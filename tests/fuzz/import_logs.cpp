// Any bytes as any file that can be imported: an error with words, or samples in the order of their times, the same number
// each time. The first byte chooses the format.
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <map>

#include "core/check.h"
#include "recorder/tools/import/byte_source.h"
#include "recorder/tools/import/find_format.h"
#include "recorder/tools/import/import_session.h"

namespace {

using namespace roseau;

struct Counter : SampleSink {
  bool receive(Sample sample) override {
    // What is decoded from a line may come after the next line's first bytes.
    if (sample.kind() == SampleKind::raw_bytes) {
      ROSEAU_CHECK(sample.header.arrival_time >= last[sample.header.stream]);
      last[sample.header.stream] = sample.header.arrival_time;
    }
    ++samples;
    return true;
  }
  std::map<StreamId, HostTime> last;
  std::uint64_t samples = 0;
};

std::uint64_t import(const recorder::ImportPlan& plan) {
  StreamTable streams;
  auto import = recorder::SessionImport::prepare(plan, streams);
  if (!import) {
    ROSEAU_CHECK(!import.error().message.empty());
    return 0;
  }
  Counter counter;
  const auto report = import->run(counter);
  ROSEAU_CHECK(report);
  return counter.samples;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace roseau::recorder;
  if (size < 2) return 0;
  static const auto path = (std::filesystem::temp_directory_path() / ("fuzz_import_" + std::to_string(::getpid()))).string();
  std::ofstream(path, std::ios::binary).write(reinterpret_cast<const char*>(data) + 1, static_cast<std::streamsize>(size - 1));
  const std::string_view text(reinterpret_cast<const char*>(data) + 1, size - 1);
  (void)sonic_format_of(text, "fuzz");
  (void)tracker_format_of(text, "fuzz");

  ImportPlan plan;
  const auto rate_hz = data[0] >= 128 ? std::optional(10.0) : std::nullopt;
  const int choice = data[0] % 11;
  if (choice < 7) {
    plan.sonics.push_back({.path = path, .file = {.format = static_cast<SonicFormat>(choice), .rate_hz = rate_hz}});
  } else {
    plan.trackers.push_back({.path = path, .file = {.format = static_cast<TrackerFormat>(choice - 7), .rate_hz = rate_hz}});
  }
  ROSEAU_CHECK(import(plan) == import(plan));
  return 0;
}
