// A session, or a part of it, as files that other programs read: for `roseau export`.
//
// Existing files are never overwritten. After an error what this call had made is gone again; stopped by the user, what is
// there is whole as far as it goes.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "core/result.h"
#include "recorder/tools/rewrite/session_output.h"
#include "recorder/tools/selection/selection.h"

namespace roseau::recorder {

struct ExportReport {
  struct Stream {
    std::string topic;
    std::filesystem::path path;
    std::uint64_t rows = 0;  // frames: pictures
    std::string remark;      // what the reader of the file should know
  };
  std::vector<Stream> streams;
  std::vector<std::string> left_out;  // topics that this form cannot hold, and why
  std::vector<std::string> damage;    // of the source: what could not be read and is missing
  bool stopped = false;               // by the user
};

/// One RFC 4180 file per topic in `directory` (made if need be): a line of names, units being part of them, then rows. Civil
/// time, then seconds from the session's start. NaN is an empty field. Samples that hold many things (markers, spectra) have a
/// row for each.
Result<ExportReport> export_csv(const std::filesystem::path& session, const SelectionOptions& options,
                                const std::filesystem::path& directory, const ToolProgress& progress = {});

/// One CF-1.8 file (netCDF-4): each stream on its own time axis.
Result<ExportReport> export_netcdf(const std::filesystem::path& session, const SelectionOptions& options,
                                   const std::filesystem::path& file, const ToolProgress& progress = {});

/// Pictures: PNG, or as they were stored (JPEG), with one CSV per camera that says when each was taken.
Result<ExportReport> export_frames(const std::filesystem::path& session, const SelectionOptions& options,
                                   const std::filesystem::path& directory, const ToolProgress& progress = {});

/// One camera as a video: .mkv lossless (FFV1), .mp4 and .avi for looking at. A video has a constant rate: the true times stand
/// in a CSV beside it.
Result<ExportReport> export_video(const std::filesystem::path& session, const SelectionOptions& options,
                                  const std::filesystem::path& file, const ToolProgress& progress = {});

/// One wind stream in Campbell Scientific's TOA5, as loggers write it and `roseau import --format toa5` reads it.
Result<ExportReport> export_toa5(const std::filesystem::path& session, const SelectionOptions& options,
                                 const std::filesystem::path& file, const ToolProgress& progress = {});

}  // namespace roseau::recorder
