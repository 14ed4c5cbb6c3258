// What to import: recordings made with other programs, to become one session.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/frame.h"
#include "core/result.h"
#include "core/time.h"
#include "core/wind_geometry.h"
#include "recorder/tools/import/displacement_file.h"
#include "recorder/tools/import/sonic_file.h"

namespace roseau::recorder {

/// All times are laid on one axis. A file with time stamps begins at its first stamp, any other at the session's begin;
/// `start_offset` (later: positive) comes on top. The session's begin is the earliest first stamp, if `begin` does not say.
struct ImportPlan {
  struct Video {
    std::string topic;  // "/camera0/image"; the device is its first part
    std::string path;
    std::optional<double> rate_hz;  // not given: the container's times
    Duration start_offset{0};
    PixelFormat format = PixelFormat::bgr8;  // or mono8
  };
  struct Sonic {
    std::string name = "sonic";  // topic "/<name>/wind"
    std::string path;
    SonicFileOptions file;
    std::string model;  // for people; empty: not known
    WindAxes axes = WindAxes::gill_spar;
    double north_offset_deg = 0;
    Duration start_offset{0};
  };
  struct DisplacementSeries {
    std::string name;  // topic "/displacement/<name>"; empty: after the file
    std::string path;
    DisplacementFileOptions file;
    Duration start_offset{0};
  };

  std::vector<Video> videos;
  std::vector<Sonic> sonics;
  std::vector<DisplacementSeries> displacements;
  std::optional<Duration> begin;  // since 1970, UTC
};

/// "[TOPIC=]FILE[@FPS]" as on the command line. TOPIC: "/camera0/image", or the device alone, "camera0"; without any, the
/// device is camera<index>.
Result<ImportPlan::Video> parse_video_argument(std::string_view text, std::size_t index);

/// "T14 P1.txt" -> "T14_P1": what a file's series is called unless told.
std::string series_name(const std::string& path);

}  // namespace roseau::recorder
