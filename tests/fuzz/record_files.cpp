// Any text is either a record with a time for each sample, times strictly increasing, or an error with words.
#include "core/check.h"
#include "tests/unit/recorder/import/read_record.h"

namespace {

template <class Record>
void check(const roseau::Result<Record>& record) {
  if (!record) {
    ROSEAU_CHECK(!record.error().message.empty());
    return;
  }
  ROSEAU_CHECK(!record->samples.empty());
  const auto& times = record->times.since_first;
  ROSEAU_CHECK(times.size() == record->samples.size());
  for (std::size_t i = 1; i < times.size(); ++i) ROSEAU_CHECK(times[i] > times[i - 1]);
}

}  // namespace

// The first byte chooses whether a rate is given.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  const std::string_view text(reinterpret_cast<const char*>(data) + 1, size - 1);
  const auto rate_hz = data[0] % 2 != 0 ? std::optional(20.0) : std::nullopt;
  check(roseau::recorder::parse_sonic_file(text, "fuzz", {.rate_hz = rate_hz}));
  check(roseau::recorder::parse_sonic_file(text, "fuzz", {.columns = "u=1,v=2,time=3", .rate_hz = rate_hz}));
  check(roseau::recorder::parse_displacement_file(text, "fuzz", {.rate_hz = rate_hz}));
  return 0;
}
