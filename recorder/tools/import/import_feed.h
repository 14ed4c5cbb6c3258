// One imported file as a sequence of samples that can be looked at before they are taken.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "core/result.h"
#include "core/sample.h"
#include "core/stream.h"
#include "recorder/tools/import/import_plan.h"
#include "recorder/tools/import/import_session.h"

namespace roseau::recorder {

class ImportFeed {
 public:
  virtual ~ImportFeed() = default;
  /// Where the file's first sample lies by its own stamp, since 1970; nothing when it has none.
  virtual std::optional<Duration> begin() const { return std::nullopt; }
  virtual Duration start_offset() const = 0;
  /// Opens what there is to open. `start`: host time of the file's first moment, offset included.
  virtual Result<void> start(HostTime start, StreamTable& streams) = 0;
  /// Time of the next sample; nothing at the end.
  virtual Result<std::optional<HostTime>> next_time() = 0;
  /// The sample whose time next_time() told.
  virtual Sample take() = 0;
  /// How much has been handed on, 0 to 1.
  virtual double share() const = 0;
  /// Of every stream: topic, path, rate, invalid samples and remarks; the rest is the caller's.
  virtual std::vector<ImportReport::Stream> describe() const = 0;
};

Result<std::unique_ptr<ImportFeed>> make_feed(const ImportPlan::Video& video);
Result<std::unique_ptr<ImportFeed>> make_feed(const ImportPlan::Sonic& sonic);
Result<std::unique_ptr<ImportFeed>> make_feed(const ImportPlan::Tracker& tracker);
Result<std::unique_ptr<ImportFeed>> make_feed(const ImportPlan::DisplacementSeries& displacement);

}  // namespace roseau::recorder
