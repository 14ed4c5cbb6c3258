// HealthReporter: how everything is, once a second, from the counters and states of all parts.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "core/sample.h"
#include "core/stream.h"
#include "daemon/supervisor.h"
#include "recorder/recorder.h"
#include "sync/counters.h"

namespace roseau::daemon {

class HealthReporter {
 public:
  HealthReporter(StreamTable& streams, sync::CounterTable& counters, const Supervisor& supervisor,
                 const recorder::Recorder& recorder);

  /// A Health sample on /roseau/health as of `now`. Rates are means since the report before. One thread.
  Sample sample(HostTime now);

  /// What was dropped before the recorder since the call before, as Drop samples on /roseau/drops. One thread.
  std::vector<Sample> new_drops(HostTime now);

  /// Of every stream, as far as the recorder has no part in it: for the recorder to add its own. Thread-safe.
  std::map<std::string, StreamCounters> upstream_counters() const;
  /// Of every stream, recorded and dropped by the recorder included. Thread-safe.
  std::map<std::string, StreamCounters> counters() const;

 private:
  StreamTable& streams_;
  sync::CounterTable& counters_;
  const Supervisor& supervisor_;
  const recorder::Recorder& recorder_;
  StreamId stream_;
  std::uint32_t sequence_ = 0;
  HostTime last_;
  std::map<std::string, std::uint64_t> last_received_;
  StreamId drop_stream_;
  std::uint32_t drop_sequence_ = 0;
  std::map<std::string, std::uint64_t> reported_drops_;
};

}  // namespace roseau::daemon
