#include "daemon/cli.h"

#include <CLI/CLI.hpp>
#include <functional>
#include <limits>
#include <string>

#include "daemon/commands.h"
#include "daemon/version.h"

namespace roseau::daemon {

namespace {

/// One subcommand: its options are bound to the arguments, its run function is called when it was named.
class Commands {
 public:
  explicit Commands(CLI::App& app) : app_(app) {}

  template <class Arguments>
  CLI::App* add(const std::string& name, const std::string& description, Arguments& arguments,
                int (*command)(const Arguments&)) {
    CLI::App* sub = app_.add_subcommand(name, description);
    sub->callback([this, &arguments, command] { selected_ = [&arguments, command] { return command(arguments); }; });
    return sub;
  }
  int run() const { return selected_(); }

 private:
  CLI::App& app_;
  std::function<int()> selected_;
};

void add_json(CLI::App* sub, bool& json) { sub->add_flag("--json", json, "One JSON object on stdout"); }

void add_session_options(CLI::App* sub, SessionArguments& arguments) {
  sub->add_option("--record", arguments.record, "Record from the start, into this directory");
  sub->add_flag("--headless", arguments.headless, "No live page");
  sub->add_option("--port", arguments.port, "Port of the live page (0: any free one)");
  sub->add_option("--for", arguments.seconds, "Stop after this many seconds")->check(CLI::PositiveNumber);
  add_json(sub, arguments.json);
}

struct AllArguments {
  RunArguments run;
  ReplayArguments replay;
  bool replay_max = false;
  SimulateArguments simulate;
  EmulateArguments emulate;
  ImportArguments import;
  FilesArguments info;
  FilesArguments verify;
  RecoverArguments recover;
  CutArguments cut;
  MergeArguments merge;
  ExportArguments export_session;
  RecordArguments record;
  EstimateArguments estimate;
  TreeArguments tree;
};

void add_run(Commands& commands, AllArguments& all) {
  auto* sub = commands.add("run", "Capture from the configured devices, with the live page", all.run, run_command);
  sub->add_option("config", all.run.config, "Configuration (TOML); config/reference.toml explains every key")->required();
  add_session_options(sub, all.run.session);
}

void add_replay(Commands& commands, AllArguments& all) {
  auto& arguments = all.replay;
  auto* sub = commands.add("replay", "Play a recorded session through the same analysis", arguments, replay_command);
  sub->add_option("session", arguments.file, "Session file (.mcap)")->required();
  auto* speed =
      sub->add_option("--speed", arguments.speed, "Recorded seconds per second (default 1)")->check(CLI::PositiveNumber);
  sub->add_flag_callback(
         "--max", [&arguments] { arguments.speed = std::numeric_limits<double>::infinity(); }, "As fast as possible")
      ->excludes(speed);
  sub->add_flag("--loop", arguments.loop, "Start again at the end");
  sub->add_option("--config", arguments.config, "Analyse with this configuration instead of the recorded one");
  add_session_options(sub, arguments.session);
}

void add_simulate(Commands& commands, AllArguments& all) {
  auto& arguments = all.simulate;
  auto* sub = commands.add("simulate", "Write a session of the simulated rig, with its truth", arguments, simulate_command);
  sub->add_option("scene", arguments.scene, "Scene (TOML); the demo's scene when absent");
  sub->add_option("-o,--output", arguments.output, "Session file to write (.mcap)")->required();
  sub->add_option("--seconds", arguments.seconds, "How long (default 60)")->check(CLI::PositiveNumber);
  sub->add_option("--seed", arguments.seed, "Instead of the scene's own");
  sub->add_option("--image-storage", arguments.image_storage, "How pictures are stored: raw (default), png (lossless), jpeg")
      ->check(CLI::IsMember({"raw", "png", "jpeg"}));
  sub->add_option("--jpeg-quality", arguments.jpeg_quality, "Default 90")->check(CLI::Range(1, 100));
  add_json(sub, arguments.json);
}

void add_emulate(Commands& commands, AllArguments& all) {
  auto& arguments = all.emulate;
  auto* sub = commands.add("emulate", "Play a scene's instruments on ttys and sockets, as the real ones would speak", arguments,
                           emulate_command);
  sub->add_option("scene", arguments.scene, "Scene (TOML); the demo's scene when absent");
  sub->add_option("--sonic", arguments.sonic, "Where: pty:, pty:/tmp/sonic, tcp-listen://127.0.0.1:4001, ...");
  sub->add_option("--tracker", arguments.tracker, "Where the magnetic tracker speaks");
  sub->add_option("--led-board", arguments.led_board, "Where the LED board speaks");
  sub->add_option("--for", arguments.seconds, "Stop after this many seconds")->check(CLI::PositiveNumber);
  sub->add_option("--seed", arguments.seed, "Instead of the scene's own");
  add_json(sub, arguments.json);
}

void add_import(Commands& commands, AllArguments& all) {
  auto& arguments = all.import;
  auto* sub = commands.add("import", "Make a session from videos, sonic and tracker files and displacement series", arguments,
                           import_command);
  sub->add_option("-o,--output", arguments.output, "Session file to write (.mcap)")->required();
  sub->add_option("--video", arguments.videos, "[TOPIC=]FILE[@FPS]; once per camera, topics /camera0/image, ... by default");
  sub->add_option("--sonic", arguments.sonics, "[NAME=]FILE of a sonic anemometer; may repeat, each with a name then");
  sub->add_option("--tracker", arguments.trackers, "[NAME=]FILE of a magnetic tracker; may repeat");
  sub->add_option("--format", arguments.formats,
                  "Sonic: csv, toa5, tob1, ghg, nmea, trisonica; tracker: fastrak, fastrak_matrices, liberty (default: by "
                  "looking); once for all, or once per file");
  sub->add_option("--columns", arguments.columns,
                  "Sonic columns, when not named as usual: u=U,v=V,w=W,t=T_SONIC,time=TIMESTAMP");
  sub->add_option("--sonic-rate", arguments.sonic_rate_hz, "Hz, when the file has no times")->check(CLI::PositiveNumber);
  sub->add_option("--tracker-rate", arguments.tracker_rate_hz, "Hz per station, when the file has no times")
      ->check(CLI::PositiveNumber);
  sub->add_option("--tracker-unit", arguments.tracker_unit, "inch, cm or m: what the tracker's file counts in");
  sub->add_option("--temperature-unit", arguments.temperature_unit, "kelvin or celsius (default: by the values)");
  sub->add_option("--north-offset", arguments.north_offsets_deg,
                  "Degrees clockwise from north to the sonic's north mark; once for all, or once per sonic");
  sub->add_option("--displacement", arguments.displacements, "[NAME=]FILE of one displacement series; may repeat");
  sub->add_option("--rate", arguments.displacement_rate_hz, "Hz of the displacement series")->check(CLI::PositiveNumber);
  sub->add_option("--unit", arguments.displacement_unit, "Of the displacement: px, m, strain or other");
  sub->add_option("--start-offset", arguments.start_offset_s,
                  "Seconds by which sonic, tracker and displacement start after the video");
  sub->add_option("--site", arguments.site, "Site sheet (TOML) to travel with the session");
  add_json(sub, arguments.json);
}

void add_tools(Commands& commands, AllArguments& all) {
  auto* info = commands.add("info", "What a session holds: streams, rates, gaps, wind", all.info, info_command);
  info->add_option("files", all.info.files, "Session files")->required();
  add_json(info, all.info.json);

  auto* verify = commands.add("verify", "Check every checksum, order and count of a session", all.verify, verify_command);
  verify->add_option("files", all.verify.files, "Session files")->required();
  add_json(verify, all.verify.json);

  auto* estimate =
      commands.add("estimate", "Oscillator, force and wind of a session, off line", all.estimate, estimate_command);
  estimate->add_option("session", all.estimate.file, "Session file (.mcap)")->required();
  estimate->add_option("-o,--output", all.estimate.output, "Session file to write, with the estimates");
  estimate->add_option("--band", all.estimate.band_hz, "Where the natural frequency is looked for, Hz: LOW:HIGH");
  estimate->add_flag("--free-decay", all.estimate.free_decay, "Pull and release: fit a damped sinusoid to each series");
  add_json(estimate, all.estimate.json);
}

void add_record(Commands& commands, AllArguments& all) {
  auto& arguments = all.record;
  auto* sub = commands.add("record", "Start, stop or trigger the recording of the daemon that runs on this machine", arguments,
                           record_command);
  sub->add_option("order", arguments.order, "start, stop, trigger or status (default)")
      ->check(CLI::IsMember({"start", "stop", "trigger", "status"}));
  sub->add_option("--text", arguments.text, "What the trigger is for");
  sub->add_option("--port", arguments.port, "Port of its live page (default 8420)");
  add_json(sub, arguments.json);
}

void add_recover(Commands& commands, AllArguments& all) {
  auto& arguments = all.recover;
  auto* sub = commands.add("recover", "Make a cut or damaged session whole again, and say exactly what is lost", arguments,
                           recover_command);
  sub->add_option("session", arguments.file, "Session file (.mcap); it is only read")->required();
  auto* output = sub->add_option("-o,--output", arguments.output, "File to write (default: SESSION.recovered.mcap beside it)");
  sub->add_flag("--in-place", arguments.in_place, "Give the file itself its missing end; torn bytes go to SESSION.mcap.torn")
      ->excludes(output);
  add_json(sub, arguments.json);
}

void add_part_options(CLI::App* sub, PartArguments& part) {
  sub->add_option("--from", part.from,
                  "First time: seconds from the start, UTC (2026-11-22T15:46:08Z) or host ns (123456789012ns)");
  sub->add_option("--to", part.to, "First time that is no longer wanted");
  sub->add_option("--for", part.seconds, "Seconds, instead of --from or --to")->check(CLI::PositiveNumber);
  sub->add_option("--topic", part.topics, "Only these topics; * stands for anything (quote it). May repeat");
  sub->add_option("--without", part.without, "Not these topics. May repeat");
}

void add_rewriters(Commands& commands, AllArguments& all) {
  auto* cut = commands.add("cut", "A part of a session, by time and topic, as a session of its own", all.cut, cut_command);
  cut->add_option("session", all.cut.file, "Session file (.mcap)")->required();
  cut->add_option("-o,--output", all.cut.output, "Session file to write (.mcap)")->required();
  add_part_options(cut, all.cut.part);
  add_json(cut, all.cut.json);

  auto* merge = commands.add("merge", "The parts of a session, or the sessions of several hosts, into one by corrected time",
                             all.merge, merge_command);
  merge->add_option("files", all.merge.files, "Session files; times go onto the first one's axis")->required();
  merge->add_option("-o,--output", all.merge.output, "Session file to write (.mcap)")->required();
  merge->add_option("--prefix", all.merge.prefixes,
                    "In front of a file's colliding topics, instead of its host's name; one per "
                    "file, in their order");
  add_json(merge, all.merge.json);
}

void add_export(Commands& commands, AllArguments& all) {
  auto& arguments = all.export_session;
  auto* sub =
      commands.add("export", "A session, or a part of it, as CSV, NetCDF, pictures, video or TOA5", arguments, export_command);
  sub->add_option("session", arguments.file, "Session file (.mcap)")->required();
  auto* form = sub->add_option_group("form");
  form->add_option("--csv", arguments.csv, "Directory: one CSV file per topic");
  form->add_option("--netcdf", arguments.netcdf, "File: NetCDF-CF of wind, displacements, poses and estimates");
  form->add_option("--frames", arguments.frames, "Directory: pictures as PNG (or JPEG, where stored so) and their times");
  form->add_option("--video", arguments.video, "File: one camera; .mkv lossless, .mp4 for looking at; true times beside it");
  form->add_option("--toa5", arguments.toa5, "File: one wind stream as Campbell's loggers write it");
  form->require_option(1);
  add_part_options(sub, arguments.part);
  add_json(sub, arguments.json);
}

void add_tree(Commands& commands, AllArguments& all) {
  auto& arguments = all.tree;
  auto* sub = commands.add("tree", "Read or grow a tree: its figures, what was mended, glTF", arguments, tree_command);
  auto* source = sub->add_option_group("source");
  source->add_option("file", arguments.file, "Digitised (.mtg), or cylinders of a laser scan (.mat, or text)");
  source->add_flag("--grow", arguments.grow, "A tree grown from a seed instead");
  source->require_option(1);
  sub->add_option("--seed", arguments.seed, "Of the grown tree, or of how a digitised one's leaves hang (default 1)");
  sub->add_option("--dressing", arguments.dressing,
                  "Dressing file (.drf) with the units of an .mtg (default: of the same name)");
  sub->add_option("--length-unit", arguments.length_unit_m, "Metres per unit of the .mtg's coordinates (default 0.01)")
      ->check(CLI::PositiveNumber);
  sub->add_option("--diameter-unit", arguments.diameter_unit_m, "Metres per unit of the .mtg's diameters (default 0.001)")
      ->check(CLI::PositiveNumber);
  sub->add_option("--leaf-column", arguments.leaf_column,
                  "Column of the .mtg that counts leaves (default NFe; empty: no leaves)");
  sub->add_option("--simplify", arguments.simplify, "To at most this many nodes, with the same wood and leaves")
      ->check(CLI::Range(std::size_t{2}, std::size_t{100'000'000}));
  sub->add_option("--gltf", arguments.gltf, "Write the tree as binary glTF (.glb)");
  auto* modes = sub->add_option("--modes", arguments.modes, "Natural frequencies of its first so many modes")
                    ->check(CLI::Range(std::size_t{1}, std::size_t{100'000}));
  sub->add_option("--density", arguments.density_kg_m3, "Of the wood, kg/m3 (default 1000, green)")->needs(modes);
  sub->add_option("--young-modulus", arguments.young_modulus_pa, "Of the wood, Pa (default 1e10)")->needs(modes);
  sub->add_option("--leaf-mass", arguments.leaf_mass_per_area_kg_m2, "Of a square metre of leaves, kg (default 0.2)")
      ->needs(modes);
  add_json(sub, arguments.json);
}

}  // namespace

int run_command_line(int argc, char** argv) {
  CLI::App app{"roseau: capture of plants and boats moving in wind and waves, and what moved them", "roseau"};
  app.set_version_flag("--version", kVersion);
  app.require_subcommand(1);
  Commands commands(app);
  AllArguments arguments;
  add_run(commands, arguments);
  add_replay(commands, arguments);
  add_simulate(commands, arguments);
  add_emulate(commands, arguments);
  add_import(commands, arguments);
  add_tools(commands, arguments);
  add_recover(commands, arguments);
  add_rewriters(commands, arguments);
  add_export(commands, arguments);
  add_record(commands, arguments);
  add_tree(commands, arguments);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    // CLI11's own numbers tell its errors apart; ours is one: wrong use. Help and version are no errors.
    return app.exit(error) == 0 ? kExitOk : kExitUsage;
  }
  return commands.run();
}

}  // namespace roseau::daemon
