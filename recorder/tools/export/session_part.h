// SessionPart: the streams of a session that an export is about, and their samples in order.
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "core/frame.h"
#include "core/sample.h"
#include "recorder/format/indexed_reader.h"
#include "recorder/tools/export/export_session.h"
#include "recorder/tools/selection/selection.h"
#include "schema/conversion.h"

namespace roseau::recorder {

class SessionPart {
 public:
  struct Stream {
    StreamInfo info;
    SampleKind kind = SampleKind::raw_bytes;
    std::uint64_t messages = 0;  // in the whole file
  };

  static Result<SessionPart> open(const std::filesystem::path& path, const SelectionOptions& options);

  /// By channel id. Only those this program can read; report().left_out names the others.
  const std::map<std::uint16_t, Stream>& streams() const { return streams_; }
  /// Keeps the streams that `wanted` says yes to.
  void keep(const std::function<bool(const Stream&)>& wanted);

  /// Every sample of the streams in order, frames without their pixels (see frames). `take` may end it by an Error.
  Result<void> for_each_sample(const std::function<Result<void>(std::uint16_t channel, const Sample&)>& take,
                               const ToolProgress& progress);
  Result<void> for_each_frame(const std::function<Result<void>(std::uint16_t channel, const schema::FrameView&)>& take,
                              const ToolProgress& progress);

  /// Civil time minus host time, where the session knows it.
  const std::optional<Duration>& utc_minus_host_time() const { return info_.utc_minus_host_time; }
  std::string utc(HostTime time, int digits = 9) const;                      // empty where it is not known
  double seconds(HostTime time) const { return to_seconds(time - begin_); }  // from the session's first message
  HostTime begin() const { return begin_; }
  const mcap::SessionInfo& info() const { return info_; }
  const std::filesystem::path& path() const { return path_; }
  mcap::IndexedReader& reader() { return *reader_; }
  ExportReport& report() { return report_; }

 private:
  using TakeMessage = std::function<Result<void>(std::uint16_t, const mcap::Message&, const SampleHeader& known)>;
  Result<void> for_each(const TakeMessage& take, const ToolProgress& progress);
  void damaged(std::string sentence);

  std::filesystem::path path_;
  std::unique_ptr<mcap::IndexedReader> reader_;
  mcap::SessionInfo info_;
  Selection selection_;
  HostTime begin_;
  HostTime end_;
  std::map<std::uint16_t, Stream> streams_;
  std::unique_ptr<StreamTable> table_ = std::make_unique<StreamTable>();
  ExportReport report_;
};

}  // namespace roseau::recorder
