// When each stream of a session has how much, for `roseau info`: made from the index alone and a few small chunks, so it is
// quick on files of any size.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "core/result.h"
#include "core/time.h"
#include "recorder/format/indexed_reader.h"

namespace roseau::recorder {

struct Timeline {
  struct Slice {
    std::uint64_t messages = 0;
    // What the health stream and the Gap and Drop samples say of this slice.
    bool has_gaps = false;
    bool has_drops = false;
    bool has_bad = false;
  };
  struct Line {
    std::string topic;
    std::vector<Slice> slices;
  };
  struct Mark {
    double time_s = 0;  // from the session's start
    bool is_trigger = false;
    std::string text;  // "mark 'gust'"
  };
  HostTime begin;
  HostTime end;
  std::vector<Line> lines;  // by topic
  std::vector<Mark> marks;

  double slice_s() const { return lines.empty() ? 0 : to_seconds(end - begin) / static_cast<double>(lines[0].slices.size()); }
};

/// `slices` time slices of equal length, at least one.
Result<Timeline> make_timeline(const std::filesystem::path& path, mcap::IndexedReader& reader, std::size_t slices);

enum class TimelineStyle : std::uint8_t { blocks, ascii };

/// One character per slice: its height is the number of messages against the fullest slice; g: samples missing in the device's
/// numbering, d: dropped, b: bad; blank: nothing.
std::string line_text(const Timeline::Line& line, TimelineStyle style);

/// All lines with the streams' names, the marks and their words below.
std::string to_text(const Timeline& timeline, TimelineStyle style);

/// How many slices such a text has room for in lines of this width.
std::size_t slices_in(std::size_t width);

}  // namespace roseau::recorder
