// What to import: recordings made with other programs, to become one session.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/frame.h"
#include "core/result.h"
#include "core/sample.h"
#include "core/time.h"
#include "core/wind_geometry.h"

namespace roseau::recorder {

/// How an anemometer's file is written (docs/importing.md).
enum class SonicFormat : std::uint8_t { automatic, csv, toa5, tob1, ghg, nmea, trisonica };
std::string_view to_string(SonicFormat format);
Result<SonicFormat> sonic_format_from_string(std::string_view name);

/// How a magnetic tracker's file is written.
enum class TrackerFormat : std::uint8_t { automatic, fastrak, fastrak_matrices, liberty };
std::string_view to_string(TrackerFormat format);
Result<TrackerFormat> tracker_format_from_string(std::string_view name);

enum class TemperatureUnit : std::uint8_t {
  automatic,  // by the file's units, else kelvin if the first value lies about 150 or more
  celsius,
  kelvin,
};
Result<TemperatureUnit> temperature_unit_from_string(std::string_view name);

/// What a tracker's file counts lengths in.
enum class TrackerUnit : std::uint8_t { inch, centimetre, metre };
std::string_view to_string(TrackerUnit unit);
Result<TrackerUnit> tracker_unit_from_string(std::string_view name);

/// "px", "m", "strain", "other".
Result<LengthUnit> length_unit_from_string(std::string_view name);

struct SonicFileOptions {
  SonicFormat format = SonicFormat::automatic;
  /// Of tables: "u=U,v=V,w=W,t=T_SONIC,c=SOS,status=DIAG,time=TIMESTAMP"; only what the usual names do not find needs saying.
  /// status: any number but 0 means that the instrument flags the row.
  std::string columns;
  std::optional<double> rate_hz;  // not given: from the file's times
  TemperatureUnit temperature_unit = TemperatureUnit::automatic;
};

struct TrackerFileOptions {
  TrackerFormat format = TrackerFormat::automatic;
  std::optional<TrackerUnit> unit;  // not given: fastrak and liberty inch, as the trackers are delivered; matrices metre
  std::optional<double> rate_hz;    // per station; not given: liberty by its times, fastrak 120 / stations, matrices 100
};

struct DisplacementFileOptions {
  /// "x=strain1,y=strain2,time=TIMESTAMP", by name or, without names, by number. Not given: the only column, or the columns
  /// called x and y; two unnamed columns are x and y.
  std::string columns;
  std::optional<double> rate_hz;  // not given: from the time column
  LengthUnit unit = LengthUnit::other;
};

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
    std::string name = "sonic";  // topic "/<name>/wind" of tables; "/<name>/raw" of logs, and "/<name>/wind" decoded from it
    std::string path;
    SonicFileOptions file;
    std::string model;                    // for people; empty: not known
    WindAxes axes = WindAxes::gill_spar;  // of tables; logs have their instrument's
    double north_offset_deg = 0;
    Duration start_offset{0};
  };
  struct Tracker {
    std::string name = "tracker";  // topics "/<name>/station1/pose", ...; of a log, decoded from "/<name>/raw"
    std::string path;
    TrackerFileOptions file;
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
  std::vector<Tracker> trackers;
  std::vector<DisplacementSeries> displacements;
  std::optional<Duration> begin;  // since 1970, UTC
};

/// "[TOPIC=]FILE[@FPS]" as on the command line. TOPIC: "/camera0/image", or the device alone, "camera0"; without any, the
/// device is camera<index>.
Result<ImportPlan::Video> parse_video_argument(std::string_view text, std::size_t index);

/// "[NAME=]FILE" as on the command line: the name, if one is given, and the file. A '=' behind anything that is no name belongs
/// to the file's name.
struct NamedFile {
  std::optional<std::string> name;
  std::string path;
};
NamedFile parse_named_file(std::string_view text);

/// "T14 P1.txt" -> "T14_P1": what a file's series is called unless told.
std::string series_name(const std::string& path);

}  // namespace roseau::recorder
