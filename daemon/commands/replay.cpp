#include <cmath>
#include <utility>

#include "core/log.h"
#include "daemon/commands.h"
#include "daemon/commands/failure.h"
#include "daemon/commands/replay_plan.h"
#include "daemon/host_clock.h"
#include "daemon/session.h"
#include "replay/session_source.h"
#include "sync/sequencer.h"

namespace roseau::daemon {

namespace {

/// The configuration to analyse with: as asked for, as recorded, or the defaults.
Result<Config> analysis_config(const ReplayArguments& arguments, const replay::SessionSource& source) {
  if (arguments.config) return load_config(*arguments.config);
  if (source.config_text().empty()) {
    Config config;
    config.site_text = source.site_text();
    return config;
  }
  auto config = parse_recorded_config(source.config_text(), arguments.file.string() + " (config.toml in it)");
  if (config) config->site_text = source.site_text();
  return config;
}

}  // namespace

Result<SessionPlan> make_replay_plan(const ReplayArguments& arguments) {
  auto source =
      replay::SessionSource::open_file(arguments.file, {.speed = arguments.speed, .loop = arguments.loop, .now = host_now});
  if (!source) return source.error();
  for (const auto& damage : (*source)->damage()) log("replay")->warn("{}", damage);
  auto config = analysis_config(arguments, **source);
  if (!config) return config.error();
  SessionPlan plan;
  plan.config = std::move(*config);
  plan.config.recording.at_start = false;  // only --record records a replay
  plan.mode = "replay";
  Duration lookahead = plan.config.window;
  for (const auto& stream : (*source)->inputs()) lookahead = sync::Sequencer::window_for(stream, lookahead);
  (*source)->set_lookahead(lookahead);
  plan.cameras = (*source)->cameras();
  plan.recorded_skips = (*source)->skips();
  plan.player = &(*source)->player();
  plan.marks = (*source)->marks();
  plan.stay_at_end = [replayed = source->get()](bool stay) { replayed->stay_at_end(stay); };
  plan.utc_minus_host_time = (*source)->info().utc_minus_host_time;
  plan.expected_duration_s = arguments.loop ? 0 : to_seconds((*source)->duration());
  plan.arguments = arguments.session;
  plan.sources.push_back(std::move(*source));
  return plan;
}

int replay_command(const ReplayArguments& arguments) {
  auto plan = make_replay_plan(arguments);
  if (!plan) return failed(plan.error());
  return run_session(std::move(*plan));
}

}  // namespace roseau::daemon
