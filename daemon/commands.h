// The subcommands of the program. Each returns the process's exit status: 0 ok, 1 failed (the message is on stderr).
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace roseau::daemon {

inline constexpr int kExitOk = 0;
inline constexpr int kExitFailed = 1;
inline constexpr int kExitUsage = 2;

/// What `run` and `replay` share.
struct SessionArguments {
  std::optional<std::filesystem::path> record;  // directory; empty: as configured
  bool headless = false;                        // no page
  std::optional<std::uint16_t> port;            // of the page
  std::optional<double> seconds;                // stop after this long
  bool json = false;
};

struct RunArguments {
  std::filesystem::path config;
  SessionArguments session;
};
int run_command(const RunArguments& arguments);

struct ReplayArguments {
  std::filesystem::path file;
  double speed = 1;  // infinity: as fast as possible
  bool loop = false;
  std::optional<std::filesystem::path> config;  // instead of the recorded one
  SessionArguments session;
};
int replay_command(const ReplayArguments& arguments);

struct SimulateArguments {
  std::optional<std::filesystem::path> scene;  // the built-in demo scene when absent
  std::filesystem::path output;
  double seconds = 60;
  std::optional<std::uint64_t> seed;
  std::string image_storage = "raw";  // png, jpeg
  int jpeg_quality = 90;
  bool json = false;
};
int simulate_command(const SimulateArguments& arguments);

struct EmulateArguments {
  std::optional<std::filesystem::path> scene;  // the built-in demo scene when absent
  std::optional<std::string> sonic;            // links; when none is given each instrument gets a pseudo terminal
  std::optional<std::string> tracker;
  std::optional<std::string> led_board;
  std::optional<double> seconds;  // until asked to stop when absent
  std::optional<std::uint64_t> seed;
  bool json = false;
};
int emulate_command(const EmulateArguments& arguments);

struct ImportArguments {
  std::filesystem::path output;
  std::vector<std::string> videos;     // [TOPIC=]FILE[@FPS]
  std::vector<std::string> sonics;     // [NAME=]FILE
  std::vector<std::string> trackers;   // [NAME=]FILE
  std::vector<std::string> formats;    // of sonics and trackers, in their order; one for all of a kind; none: by looking
  std::optional<std::string> columns;  // "u=U,v=V,w=W,t=T_SONIC,time=TIMESTAMP"
  std::optional<double> sonic_rate_hz;
  std::optional<double> tracker_rate_hz;
  std::optional<std::string> tracker_unit;      // "inch", "cm", "m"
  std::optional<std::string> temperature_unit;  // "kelvin", "celsius"
  std::vector<double> north_offsets_deg;        // in the order of the sonics; one for all
  std::vector<std::string> displacements;       // [NAME=]FILE
  std::optional<double> displacement_rate_hz;
  std::string displacement_unit = "other";
  double start_offset_s = 0;  // of the sonic, tracker and displacement series against the videos
  std::optional<std::filesystem::path> site;
  bool json = false;
};
int import_command(const ImportArguments& arguments);

struct FilesArguments {
  std::vector<std::filesystem::path> files;
  bool json = false;
};
int info_command(const FilesArguments& arguments);
int verify_command(const FilesArguments& arguments);

struct RecoverArguments {
  std::filesystem::path file;
  std::optional<std::filesystem::path> output;  // beside the file when absent
  bool in_place = false;                        // instead of an output
  bool json = false;
};
int recover_command(const RecoverArguments& arguments);

/// Which part of a session; recorder/tools/selection says what the texts mean.
struct PartArguments {
  std::optional<std::string> from;
  std::optional<std::string> to;
  std::optional<double> seconds;
  std::vector<std::string> topics;
  std::vector<std::string> without;
};

struct CutArguments {
  std::filesystem::path file;
  std::filesystem::path output;
  PartArguments part;
  bool json = false;
};
int cut_command(const CutArguments& arguments);

struct ExportArguments {
  std::filesystem::path file;
  PartArguments part;
  // Exactly one of these.
  std::optional<std::filesystem::path> csv;     // directory
  std::optional<std::filesystem::path> netcdf;  // file
  std::optional<std::filesystem::path> frames;  // directory
  std::optional<std::filesystem::path> video;   // file
  std::optional<std::filesystem::path> toa5;    // file
  bool json = false;
};
int export_command(const ExportArguments& arguments);

struct MergeArguments {
  std::vector<std::filesystem::path> files;
  std::filesystem::path output;
  std::vector<std::string> prefixes;  // by file
  bool json = false;
};
int merge_command(const MergeArguments& arguments);
struct RecordArguments {
  std::string order = "status";  // "start", "stop", "trigger", "status"
  std::string text;              // trigger: what for
  std::uint16_t port = 8420;     // of the running daemon, on this machine
  bool json = false;
};
int record_command(const RecordArguments& arguments);

struct EstimateArguments {
  std::filesystem::path file;
  std::optional<std::filesystem::path> output;
  std::optional<std::string> band_hz;  // "0.15:0.35"
  bool free_decay = false;             // fit a damped sinusoid to each displacement series
  bool json = false;
};
int estimate_command(const EstimateArguments& arguments);

struct TreeArguments {
  std::optional<std::filesystem::path> file;  // .mtg, .mat or a text table of cylinders
  bool grow = false;                          // instead of a file
  std::optional<std::uint64_t> seed;          // of the grown tree, or of the leaves of a digitised one
  std::optional<std::filesystem::path> dressing;
  std::optional<double> length_unit_m;
  std::optional<double> diameter_unit_m;
  std::optional<std::string> leaf_column;
  std::optional<std::size_t> simplify;  // to at most this many nodes
  std::optional<std::filesystem::path> gltf;
  std::optional<std::size_t> modes;  // this many natural frequencies, with the material below
  std::optional<double> density_kg_m3;
  std::optional<double> young_modulus_pa;
  std::optional<double> leaf_mass_per_area_kg_m2;
  bool json = false;
};
int tree_command(const TreeArguments& arguments);

}  // namespace roseau::daemon
